// Recording from the virtual board, or from a board at the browser's serial port. The page passes bytes; the protocol is the program's.
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

/** Opens the port that the user chooses, and passes its bytes to the recorder. */
async function openPort(baudRate) {
  try {
    port = await navigator.serial.requestPort();
  } catch (error) {
    if (error.name !== 'NotFoundError') throw error;
    throw new Hinted('No port was chosen', "press Record again and choose the board's port; without one in the list, plug the board in");
  }
  try {
    await port.open({ baudRate, bufferSize: 65536 });
  } catch (error) {
    throw new Hinted(`The port does not open: ${error.message}`, 'close other programs and pages that use the port, or plug the board in again');
  }
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
        // A framing error ends one reader but not the port.
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

// The live plot: speed and command over time, the most recent points.
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

/** The number in an input, with a decimal point or comma. */
const numberIn = (id) => Number($(id).value.trim().replace(',', '.') || NaN);

function orderOf(fields) {
  const duration = numberIn('duration');
  // A board that prints text determines its sample time.
  const sample = fields.kind === 'text' ? 0 : numberIn('sample-time') / 1000;
  if (!(duration > 0 && duration <= 3600)) throw new Hinted('Duration: out of range', 'enter seconds above 0, up to 3600');
  if (fields.kind !== 'text' && !(sample >= 0.0001 && sample <= 60)) throw new Hinted('Sample time: out of range', 'enter milliseconds from 0.1 to 60000');
  return { profile: $('profile').value, duration_s: duration, sample_time_s: sample, source: fields };
}

/** Settings of a board that prints text, from the form. */
function textBoard() {
  const above0 = (id, name) => {
    const value = numberIn(id);
    if (value > 0) return value;
    $(id).focus();
    throw new Hinted(`${name}: no number above 0`, 'enter digits with a point or a comma, without the unit');
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

/** The virtual board's motor: the handout's in place of a fit. */
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
    say($('record-said'), error.message, true);
  } finally {
    await closePort();
  }
}

document.querySelectorAll('input[name=source]').forEach((choice) => (choice.onchange = showSource));
$('has-profile').onchange = showSource;
$('record').onclick = record;
$('stop-record').onclick = () => recorder.tell('stop_recording');
