// A serial port for tests: it answers as a recorded wire does. Each message of the page but ALIVE leads to the next messages of the board.
// A board that prints text is asked nothing: it begins when the port is opened, and continues at the log's times.
const ALIVE = 0x87;
let wire = [];
let prints = [];
window.setTextWire = (text) => {
  const lines = text.split('\n').map((line) => line.match(/^ *(\d+) < (".*")$/)).filter(Boolean);
  prints = lines.map(([, at, said]) => ({ at: at / 1000, bytes: new TextEncoder().encode(JSON.parse(said)) }));
};
window.setWire = (text) => {
  wire = text.split('\n').filter((line) => /^\s*\d+ [<>] [0-9a-f ]+$/.test(line)).map((line) => {
    const [, way, bytes] = line.match(/^\s*\d+ ([<>]) (.*)$/);
    return { way, bytes: Uint8Array.from(bytes.trim().split(' '), (digits) => parseInt(digits, 16)) };
  });
};
let controller;
const kind = (bytes) => bytes[2];
const port = {
  async open({ baudRate }) {
    window.opened += 1;
    port.baud = baudRate;
    port.readable = new ReadableStream({ start: (one) => (controller = one) });
    port.writable = new WritableStream({ write: said });
    const begun = controller;
    for (const { at, bytes } of prints) setTimeout(() => window.opened && begun.enqueue(bytes), at - prints[0].at);
  },
  async close() {
    window.opened -= 1;
  },
  getInfo: () => ({ usbVendorId: 0x2341, usbProductId: 0x43 }),
};
function said(bytes) {
  if (kind(bytes) === ALIVE) return;
  while (wire.length && wire[0].way === '<') wire.shift();
  while (wire.length && (wire[0].way === '>' || !wire.shift())) {
    const isAlive = kind(wire[0].bytes) === ALIVE;
    wire.shift();
    if (!isAlive) break;
  }
  // Everything up to the next question of the host.
  const answer = [];
  while (wire.length && (wire[0].way === '<' || kind(wire[0].bytes) === ALIVE)) {
    const one = wire.shift();
    if (one.way === '<') answer.push(one.bytes);
  }
  answer.forEach((one, k) => setTimeout(() => controller.enqueue(one), Math.min(k, 200)));
}
window.plugIn = () => {
  [wire, prints, window.opened] = [[], [], 0];
  Object.defineProperty(navigator, 'serial', { value: { requestPort: async () => port }, configurable: true });
};
plugIn();
