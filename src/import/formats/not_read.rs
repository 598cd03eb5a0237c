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

/// Whether lines are frames of a CAN bus: `(1690000000.123456) can0 181#0011`, or `can0  181   [8]  00 11`.
fn is_candump(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let is_frame = |line: &str| {
        let rest = match line.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
            Some((_, rest)) => rest,
            None => line,
        };
        let mut words = rest.split_whitespace();
        let is_bus = words.next().is_some_and(|word| {
            ["can", "vcan", "slcan"].iter().any(|bus| {
                (word.strip_prefix(bus)).is_some_and(|number| number.parse::<u8>().is_ok())
            })
        });
        let is_id = words.next().is_some_and(|word| {
            let id = word.split('#').next().unwrap_or_default();
            !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_hexdigit())
        });
        is_bus && is_id
    };
    lines.next().is_some_and(is_frame) && lines.next().is_some_and(is_frame)
}

/// The format of an unsupported file.
pub(super) fn form(beginning: &[u8]) -> Option<Form> {
    if is_candump(beginning) {
        return Some(Form::NotRead(
            "a log of CAN frames (candump)",
            "decode the signals by the bus's DBC file, in Python: db = cantools.database.load_file('BUS.dbc'); for m in can.LogReader(FILE): \
             print(json.dumps({'time': m.timestamp, **db.decode_message(m.arbitration_id, m.data)}))",
        ));
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
