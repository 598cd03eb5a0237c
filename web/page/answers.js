// Check, compare, diagnose: question, progress, and answer with downloads.
const VERBS = { check: 'check_runs', compare: 'compare_runs', diagnose: 'diagnose_runs' };
const LONG = {
  check: 'Errors of the recordings themselves',
  compare: 'Recorded against simulated',
  diagnose: 'Which effects cause the error',
};

function showChoice() {
  const count = chosen().length;
  for (const name of Object.keys(VERBS)) $(name).disabled = count === 0 || isAsking;
  say($('choice'), count === 0 ? 'Choose a recording first.' : `${count === 1 ? 'One recording is' : `${count} recordings are`} chosen.`);
}

let isAsking = false;
function setAsking(is) {
  isAsking = is;
  $('progress').hidden = !is;
  $('answer').setAttribute('aria-busy', String(is));
  showChoice();
}

/** The equivalent command line of the program. */
function commandLine(name, motor) {
  const words = ['motorlab', name, ...chosen().map((run) => (/^[\w.+-]+$/.test(run.name) ? run.name : `'${run.name}'`))];
  if (motor.motor) words.push('--motor motor.toml');
  if (motor.fit && name === 'diagnose') words.push('--nominal fit');
  return words.join(' ');
}

async function answer(name) {
  setAsking(true);
  say($('answer-said'), '');
  $('answer').replaceChildren();
  $('step').textContent = LONG[name];
  $('bar').removeAttribute('value');
  program.onReport = ({ what, share }) => {
    if (what) $('step').textContent = what;
    if (share !== undefined) $('bar').value = share;
  };
  try {
    const motor = await motorAsked();
    const question = {
      runs: chosen().map(({ name: file, text }) => ({ name: file, text })),
      ...motor,
      quick: $('quick').checked,
      despite_findings: $('despite').checked,
      asked: commandLine(name, motor),
    };
    const told = await program.document(VERBS[name], JSON.stringify(question));
    const about = question.runs.map((run) => run.name).join(', ');
    if (name === 'check') showFindings(about, told);
    else showPage(name, about, told);
  } catch (error) {
    say($('answer-said'), error.message, error.message !== STOPPED);
  }
  setAsking(false);
}

function showFindings(about, told) {
  const findings = told.findings.map((one) =>
    make('li', {}, make('strong', {}, `${one.severity}: `), `${one.message}; ${one.remedy} `,
      make('span', { className: 'faint' }, `${one.run}, ${one.from_s.toFixed(3)} to ${one.to_s.toFixed(3)} s`)),
  );
  $('answer').append(
    make('h3', { tabIndex: -1 }, `${findings.length ? 'Findings' : 'No findings'} (${about})`),
    make('ul', {}, ...findings),
    make('p', { className: 'row' }, downloadButton('Save as JSON', () => 'check.json', () => JSON.stringify(told, null, 2), 'application/json')),
  );
  $('answer').querySelector('h3').focus();
}

function showPage(name, about, { document: text, page, motor }) {
  const told = JSON.parse(text);
  const frame = make('iframe', { title: LONG[name], sandbox: 'allow-scripts', srcdoc: page });
  const save = (label, end, content, type) => downloadButton(label, () => `${name}${end}`, () => content, type);
  $('answer').append(
    make('h3', { tabIndex: -1 }, `${LONG[name]} (${about})`),
    told.sentence ? make('p', { className: 'lead', id: 'sentence' }, ...withCode(told.sentence)) : '',
    make('p', { className: 'row' },
      save('Save the report', '.html', page, 'text/html'),
      save('Save as JSON', '.json', text, 'application/json'),
      motor ? save(name === 'compare' ? 'Save the fitted motor' : 'Save the motor of the diagnosis', 'd.toml', motor, 'text/plain') : null),
    frame,
  );
  $('answer').querySelector('h3').focus();
}

const STOPPED = 'Stopped. The recordings are kept.';
for (const name of Object.keys(VERBS)) $(name).onclick = () => answer(name);
$('stop').onclick = () => program.end(STOPPED);
