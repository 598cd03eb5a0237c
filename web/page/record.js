// Recording: from the virtual board, or from a board at the browser's serial port. The protocol is the program's; the page moves bytes.
let port;
let writer;
let reader;

const source = () => document.querySelector('input[name=source]:checked').value;

let isRecording = false;
function showSource() {
  const needsSerial = source() !== 'virtual';
  const isText = source() === 'text';
  $('no-serial').hidden = !needsSerial || 'serial' in navigator;
  $('text-board').hidden = !isText;
  $('profile-row').hidden = isText && !$('has-profile').checked;
  $('sample-time-row').hidden = isText;
  $('fast-row').hidden = needsSerial;
  $('record').disabled = isRecording || (needsSerial && !('serial' in navigator));
  for (const name of ['example', 'try', 'hide']) $(name).disabled = isRecording;
  $('stop-record').hidden = !isRecording;
}

/** Opens the port that the user chooses, and hands its bytes to the recorder. */
async function openPort(baudRate) {
  port = await navigator.serial.requestPort();
  await port.open({ baudRate, bufferSize: 65536 });
  writer = port.writable.getWriter();
  recorder.onSend = (bytes) => writer?.write(bytes).catch(() => recorder.tell('serial_gone'));
  const { usbVendorId: vendor, usbProductId: product } = port.getInfo?.() ?? {};
  const hex = (number) => number.toString(16).padStart(4, '0');
  return vendor === undefined ? 'serial port' : `USB ${hex(vendor)}:${hex(product)}`;
}

async function readPort() {
  try {
    while (port?.readable) {
      reader = port.readable.getReader();
      try {
        for (;;) {
          const { value, done } = await reader.read();
          if (done) return;
          recorder.tell('serial_received', value);
        }
      } catch (error) {
        // A framing error ends one reader and not the port.
        if (error.name === 'NetworkError') break;
      } finally {
        reader.releaseLock();
      }
    }
  } finally {
    recorder.tell('serial_gone');
  }
}

async function closePort() {
  const open = port;
  port = undefined;
  await reader?.cancel().catch(() => {});
  writer?.releaseLock();
  writer = reader = undefined;
  await open?.close().catch(() => {});
}

// The live plot: speed over time with the command, the last points that fit the width.
const MOST_POINTS = 4000;
let plot;
let drawn;
function beginPlot() {
  drawn = [[], [], []];
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
  const axis = { stroke: colour('--ink'), grid: { stroke: colour('--grid'), width: 1 }, ticks: { stroke: colour('--grid') } };
  plot?.destroy();
  plot = new uPlot(
    {
      width: $('live').clientWidth,
      height: 220,
      cursor: { show: false },
      scales: { x: { time: false }, V: { auto: true } },
      axes: [{ ...axis, label: 'time (s)' }, { ...axis, label: 'speed (RPM)' }, { ...axis, label: 'command (V)', scale: 'V', side: 1, grid: { show: false } }],
      series: [{}, { label: 'speed', stroke: colour('--c0') }, { label: 'command', stroke: colour('--c2'), scale: 'V', paths: uPlot.paths.stepped({ align: 1 }) }],
      legend: { show: true, live: false },
    },
    drawn,
    $('live'),
  );
}

function showLive({ samples, lost, points }) {
  if (!points) return;
  for (const [t, speed, command] of points) {
    drawn[0].push(t);
    drawn[1].push(speed / RPM);
    drawn[2].push(command);
  }
  for (const column of drawn) column.splice(0, column.length - MOST_POINTS);
  plot.setData(drawn);
  say($('record-said'), `${samples} samples, ${lost === 0 ? 'none' : lost} lost`);
}

/** Records, and adds the run to the list. */
async function recordRun(order, name) {
  isRecording = true;
  showSource();
  $('live').hidden = false;
  beginPlot();
  recorder.onReport = showLive;
  try {
    const told = await recorder.document('record', JSON.stringify(order));
    const { samples, lost } = told.statistics;
    const about = [`${samples} samples, ${lost === 0 ? 'none' : lost} lost; ${told.complete ? 'complete' : `ended: ${told.ending.replaceAll('_', ' ')}`}`];
    about.push(...told.contradictions, ...told.notes);
    say($('record-said'), about[0]);
    return addRun({ ...told.run, name }, about);
  } catch (error) {
    say($('record-said'), error.message, true);
    return undefined;
  } finally {
    isRecording = false;
    showSource();
  }
}

/** The number of an input; people write a comma, too. */
const numberIn = (id) => Number($(id).value.trim().replace(',', '.') || NaN);

function orderOf(fields) {
  const duration = numberIn('duration');
  // A board that prints text has a sample time of its own.
  const sample = fields.kind === 'text' ? 0 : numberIn('sample-time') / 1000;
  if (!(duration > 0 && duration <= 3600)) throw new Error('Duration: seconds, up to an hour');
  if (fields.kind !== 'text' && !(sample >= 0.0001 && sample <= 60)) throw new Error('Sample time: 0.1 ms to 60 s');
  return { profile: $('profile').value, duration_s: duration, sample_time_s: sample, source: fields };
}

/** A board that prints text, as the form describes it. */
function textBoard() {
  const above0 = (id, name) => {
    const value = numberIn(id);
    if (value > 0) return value;
    $(id).focus();
    throw new Error(`${name}: enter a number above 0`);
  };
  return {
    kind: 'text',
    columns: $('columns').value,
    baud: Number($('baud').value),
    counts_per_rev: above0('text-counts', 'Counts per revolution'),
    supply_v: above0('text-supply', 'Supply of the driver'),
    has_profile: $('has-profile').checked,
  };
}

/** The virtual board's motor: one that is still to be fitted is none. */
async function motorOfBench() {
  if (motorKind() === 'fit') chooseHandout();
  const asked = await motorAsked();
  return asked.motor ?? '';
}

async function record() {
  say($('record-said'), '');
  try {
    if (source() === 'virtual') {
      const motor = await motorOfBench();
      await recordRun(orderOf({ kind: 'virtual', motor, seed: 7, fast: $('fast').checked }), 'virtual.csv');
      return;
    }
    const board = source() === 'text' ? textBoard() : { kind: 'board', baud: 115200 };
    const order = orderOf(board);
    board.port = await openPort(board.baud);
    const recording = recordRun(order, 'recorded.csv');
    readPort();
    await recording;
  } catch (error) {
    say($('record-said'), error.name === 'NotFoundError' ? 'No port was chosen.' : error.message, true);
  } finally {
    await closePort();
  }
}

document.querySelectorAll('input[name=source]').forEach((choice) => (choice.onchange = showSource));
$('has-profile').onchange = showSource;
$('record').onclick = record;
$('stop-record').onclick = () => recorder.tell('stop_recording');
