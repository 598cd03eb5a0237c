// The worker with the program, one call after the other. The page terminates it to stop a computation.
'use strict';
self.motorlabReport = (text) => postMessage({ report: JSON.parse(text) });
self.motorlabSend = (bytes) => postMessage({ send: bytes.slice() });
// A recording is a separate task, whose failure is reported here only.
self.onunhandledrejection = ({ reason }) => postMessage({ error: reason?.message || String(reason), isFatal: true });
let begun;
onmessage = async ({ data }) => {
  if (data.module) {
    begun = wasm_bindgen({ module_or_path: data.module });
    return;
  }
  try {
    await begun;
    const answer = await wasm_bindgen[data.verb](...data.values);
    if (data.id) postMessage({ id: data.id, answer });
  } catch (error) {
    const isFatal = error instanceof WebAssembly.RuntimeError;
    postMessage({ id: data.id, error: error.message || String(error), isFatal });
  }
};
