//! Known formats that are not supported, and how to convert each.

use super::Form;

/// First bytes, name, and remedy.
type Known = (&'static [u8], &'static str, &'static str);

/// A logic analyzer's or a simulator's value change dump.
const VCD: (&str, &str) = (
    "a dump of logic levels (VCD)",
    "convert it with sigrok: sigrok-cli -I vcd -i FILE -O csv -o log.csv",
);

const KNOWN: &[Known] = &[
    (
        b"\xd0\xcf\x11\xe0",
        "an old Excel file (.xls)",
        "open it and save the sheet with File > Save As > CSV",
    ),
    (
        b"ARROW1",
        "an Arrow or Feather file",
        "in Python: pandas.read_feather(FILE).to_parquet('log.parquet')",
    ),
    (
        b"\x93NUMPY",
        "a NumPy array (.npy)",
        "in Python: numpy.savetxt('log.csv', numpy.load(FILE), delimiter=',')",
    ),
    (
        b"#ROSBAG V2.0",
        "a ROS 1 bag",
        "convert it: rosbags-convert --src FILE --dst bag2 (pip install rosbags)",
    ),
    (
        b"MDF     ",
        "a measurement file (MDF)",
        "in Python: asammdf.MDF(FILE).to_dataframe().to_csv('log.csv')",
    ),
    (
        b"TDSm",
        "a LabVIEW TDMS file",
        "in Python: nptdms.TdmsFile(FILE).as_dataframe().to_csv('log.csv')",
    ),
    (
        b"ULog\x01\x12\x35",
        "a PX4 log (ULog)",
        "convert it: ulog2csv FILE (pip install pyulog)",
    ),
    (
        b"\xa3\x95",
        "an ArduPilot log",
        "convert it: mavlogdump.py --format csv FILE (pip install pymavlink)",
    ),
    (b"$date", VCD.0, VCD.1),
    (b"$version", VCD.0, VCD.1),
    (b"$timescale", VCD.0, VCD.1),
    (b"$comment", VCD.0, VCD.1),
    (b"BZh", "compressed with bzip2", "unpack it with bunzip2"),
    (b"\xfd7zXZ\0", "compressed with xz", "unpack it with unxz"),
    (
        b"\x28\xb5\x2f\xfd",
        "compressed with zstd",
        "unpack it with unzstd",
    ),
    (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive", "unpack it"),
    (
        b"<?xml",
        "XML",
        "in Python, with the path of its rows: pandas.read_xml(FILE, xpath='//row').to_csv('log.csv', index=False)",
    ),
    (
        b"<html",
        "a page of HTML",
        "in Python: pandas.read_html(FILE)[0].to_csv('log.csv', index=False)",
    ),
    (
        b"<!DOCTYPE html",
        "a page of HTML",
        "in Python: pandas.read_html(FILE)[0].to_csv('log.csv', index=False)",
    ),
    (
        b"<table",
        "a table of HTML",
        "in Python: pandas.read_html(FILE)[0].to_csv('log.csv', index=False)",
    ),
    (b"%PDF-", "a PDF", "look for the table that it was made of"),
    (
        b"\x80\x04\x95",
        "a Python pickle",
        "in Python: pandas.read_pickle(FILE).to_csv('log.csv')",
    ),
    (
        b"\x80\x05\x95",
        "a Python pickle",
        "in Python: pandas.read_pickle(FILE).to_csv('log.csv')",
    ),
];

/// Whether the first lines are of this kind, its name, and remedy.
type KnownLines = (fn(&str) -> bool, &'static str, &'static str);

/// Texts that no table can be made of without a decision.
const LINES: [KnownLines; 7] = [
    (
        |text| first(text, 2).all(is_can_frame) && first(text, 2).count() == 2,
        "a log of CAN frames (candump)",
        "decode the signals by the bus's DBC file, in Python: db = cantools.database.load_file('BUS.dbc'); for m in can.LogReader(FILE): \
         print(json.dumps({'time': m.timestamp, **db.decode_message(m.arbitration_id, m.data)}))",
    ),
    (
        |text| {
            text.starts_with('{')
                && text.contains("\"__REALTIME_TIMESTAMP\"")
                && text.contains("\"MESSAGE\"")
        },
        "the journal of systemd as JSON, with the numbers in its messages",
        "take them out: jq -r '\"[\\(.__REALTIME_TIMESTAMP | tonumber / 1e6)] \\(.MESSAGE)\"' FILE > log.txt",
    ),
    (
        |text| {
            text.lines().any(|line| {
                line.starts_with("Starting Klippy")
                    || (line.starts_with("Stats ") && line.contains(": gcodein="))
            })
        },
        "a log of Klipper, whose statistics have no position of a motor",
        "as a table, in Python: pandas.DataFrame([dict(re.findall(r'(\\w+)=(\\S+)', l), time=l.split()[1][:-1]) for l in open(FILE) \
         if l.startswith('Stats ')]).to_csv('log.csv', index=False)",
    ),
    (
        |text| text.lines().filter(|line| is_marlin(line)).nth(1).is_some(),
        "a log of Marlin, whose reports have the steps that were commanded and no position that was measured",
        "as a table of them: sed -nE 's/.*Count X:([-0-9]+) Y:([-0-9]+) Z:([-0-9]+).*/\\1,\\2,\\3/p' FILE > log.csv",
    ),
    (
        |text| is_mqtt(text, false, is_object) || is_mqtt(text, true, is_object),
        "a log of MQTT messages with JSON in them",
        "keep the JSON: sed 's/^[^{]*//' FILE > log.jsonl",
    ),
    (
        |text| is_mqtt(text, true, is_number),
        "a log of MQTT messages, one value a line",
        "name its columns: (echo time,topic,value; sed 's/ /,/g' FILE) > log.csv",
    ),
    (
        |text| is_mqtt(text, false, is_number),
        "a log of MQTT messages without their times",
        "record them with `mosquitto_sub -t '#' -F '%U %t %p'`; or where every topic has one message a row of 0.01 s: (echo time_s,topic,value; \
         awk 'NR==1{f=$1} $1==f{n++} {print 0.01*n\",\"$1\",\"$2}' FILE) > log.csv",
    ),
];

/// The first lines that are not empty.
fn first(text: &str, count: usize) -> impl Iterator<Item = &str> {
    let lines = text.lines().map(str::trim);
    lines.filter(|line| !line.is_empty()).take(count)
}

/// `(1690000000.123456) can0 181#0011`, or `can0  181   [8]  00 11`.
fn is_can_frame(line: &str) -> bool {
    let rest = match line.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        Some((_, rest)) => rest,
        None => line,
    };
    let mut words = rest.split_whitespace();
    let is_bus = words.next().is_some_and(|word| {
        ["can", "vcan", "slcan"]
            .iter()
            .any(|bus| (word.strip_prefix(bus)).is_some_and(|number| number.parse::<u8>().is_ok()))
    });
    let is_id = words.next().is_some_and(|word| {
        let id = word.split('#').next().unwrap_or_default();
        !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_hexdigit())
    });
    is_bus && is_id
}

/// Of M114, `X:0.10 Y:0.00 Z:0.00 E:0.00 Count X:8 Y:0 Z:0`, or M105, `T:22.00 /200.00 B:21.00 /60.00 @:127 B@:0`.
fn is_marlin(line: &str) -> bool {
    line.contains(" Count X:")
        || (line.contains("T:") && line.contains(" /") && line.contains(" @:"))
}

fn is_number(text: &str) -> bool {
    text.parse::<f64>().is_ok()
}

fn is_object(text: &str) -> bool {
    text.starts_with('{')
}

/// Whether the first lines are `a/topic payload`, after a time if it is stamped.
fn is_mqtt(text: &str, is_stamped: bool, is_payload: fn(&str) -> bool) -> bool {
    const LINES: usize = 3;
    let is_message = |line: &&str| {
        let line = match line.split_once(' ') {
            Some((time, rest)) if is_stamped && time.starts_with(|c: char| c.is_ascii_digit()) => {
                rest
            }
            _ if is_stamped => return false,
            _ => line,
        };
        let is_topic = |topic: &str| topic.contains('/') && topic.starts_with(char::is_alphabetic);
        line.split_once(' ')
            .is_some_and(|(topic, payload)| is_topic(topic) && is_payload(payload.trim()))
    };
    first(text, LINES).filter(is_message).count() == LINES
}

/// The format of an unsupported file.
pub(super) fn form(beginning: &[u8]) -> Option<Form> {
    let text = String::from_utf8_lossy(beginning);
    if let Some((_, what, remedy)) = LINES.iter().find(|(is, _, _)| is(&text)) {
        return Some(Form::NotRead(what, remedy));
    }
    if beginning.starts_with(b"PK\x03\x04") {
        let has = |name: &[u8]| beginning.windows(name.len()).any(|part| part == name);
        let (what, remedy) = match () {
            () if has(b".npy") => (
                "a ZIP archive of NumPy arrays (.npz)",
                "in Python: z = numpy.load(FILE); numpy.savetxt('log.csv', numpy.column_stack([z[k] for k in z.files]), \
                 delimiter=',', header=','.join(z.files), comments='')",
            ),
            () if has(b"xl/") || has(b"[Content_Types].xml") => (
                "an Excel file (.xlsx, a ZIP archive)",
                "open it and save the sheet with File > Save As > CSV UTF-8, or in Python: pandas.read_excel(FILE).to_csv('log.csv', index=False)",
            ),
            () if has(b"opendocument") => (
                "an OpenDocument file (.ods, a ZIP archive)",
                "open it and save the sheet with File > Save As > Text CSV",
            ),
            () => ("a ZIP archive", "unpack it, and import what is in it"),
        };
        return Some(Form::NotRead(what, remedy));
    }
    let found = KNOWN
        .iter()
        .find(|(magic, _, _)| beginning.starts_with(magic));
    found.map(|(_, what, remedy)| Form::NotRead(what, remedy))
}
