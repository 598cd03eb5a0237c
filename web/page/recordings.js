// Recordings: files that were dropped, what they lack, and the list of runs.
const runs = [];

// Label, hint, and the units that a column may have.
const POSITIONS = ['counts', 'rev', 'rad', 'mrad', 'deg', 'm', 'cm', 'mm'];
const SPEEDS = ['rpm', 'rev/s', 'rad/s', 'deg/s', 'counts/s', 'm/s', 'cm/s', 'mm/s', 'km/h'];
const COMMANDS = ['pwm', 'percent', 'share', 'servo', 'esc', 'V', 'mV', 'A', 'mA', 'N m'];
const FIELDS = {
  time: ['Time', 'column:unit, as in t_ms:ms; or 10ms for rows 10 ms apart', ['us', 'ms', 's']],
  command: ['Command', 'column:unit (pwm, V, mV, percent); or 7V@0.95s', COMMANDS],
  command_limit: ['Limit of the command', 'a number'],
  direction: ['Direction', 'column, or column:number that is backwards; none'],
  position: ['Position', 'column:unit (counts, rev, rad, deg)', POSITIONS],
  speed: ['Speed', 'column:unit (rpm, rad/s, deg/s, counts/s)', SPEEDS],
  integrate: ['Speed is', 'backward, trapezoid or forward'],
  current: ['Current', 'column:unit (A, mA)', ['A', 'mA']],
  supply: ['Supply of the driver (V)', 'volts, or column:unit'],
  counts_per_rev: ['Counts per revolution', 'all four edges counted'],
  m_per_rev: ['Travel of a revolution (m)', 'for positions in m'],
  pwm_full: ['PWM of full drive', 'such as 255'],
  wrap: ['Range of the counter', 'such as 65536 or 360'],
};

// Facts of the bench: the answer for one log is proposed for the others.
const OF_BENCH = ['supply', 'counts_per_rev', 'm_per_rev', 'pwm_full', 'wrap', 'command_limit'];

/** A name that no other run has. */
function freeName(name) {
  const taken = new Set(runs.map((run) => run.name));
  if (!taken.has(name)) return name;
  const [stem, end] = name.endsWith(".csv") ? [name.slice(0, -4), ".csv"] : [name, ""];
  let k = 2;
  while (taken.has(`${stem}-${k}${end}`)) k++;
  return `${stem}-${k}${end}`;
}

const chosen = () => runs.filter((run) => run.isChosen);

function addRun(seen, about = []) {
  const run = { ...seen, name: freeName(seen.name), isChosen: true, about };
  runs.push(run);
  showRuns();
  return run;
}

function showRuns() {
  $('runs').replaceChildren(
    ...runs.map((run) => {
      const picture = make('img', {
        alt: `Position and command of ${run.name} over time`,
        src: URL.createObjectURL(new Blob([run.preview], { type: 'image/svg+xml' })),
      });
      picture.onload = () => URL.revokeObjectURL(picture.src);
      const choose = make('input', { type: 'checkbox', checked: run.isChosen });
      choose.onchange = () => {
        run.isChosen = choose.checked;
        showChoice();
      };
      const remove = make('button', { type: 'button', 'aria-label': `Remove ${run.name}` }, 'Remove');
      remove.onclick = () => {
        runs.splice(runs.indexOf(run), 1);
        showRuns();
      };
      const facts = `${run.samples} samples, ${shown(run.duration_s)} s, every ${shown(run.sample_time_s * 1000)} ms`;
      return make(
        'li',
        {},
        make('label', { className: 'choice' }, choose, make('strong', {}, run.name), make('span', { className: 'faint' }, facts)),
        picture,
        run.about.length ? make('ul', { className: 'faint' }, ...run.about.map((text) => make('li', {}, ...withCode(text)))) : null,
        make('p', { className: 'row' }, downloadButton('Save the run file', () => run.name, () => run.text, 'text/csv'),
          run.mapping ? downloadButton('Save the mapping', () => 'map.toml', () => run.mapping, 'text/plain') : null,
          run.rejected ? downloadButton('Save the rejected rows', () => 'rejected.csv', () => run.rejected, 'text/csv') : null,
          remove),
      );
    }),
  );
  $('no-runs').hidden = runs.length > 0;
  showChoice();
}

/** The recognised columns and units of a log, in sentences. */
function aboutLog(found) {
  const about = found.understood.map((one) => `${one.what === 'counts_per_rev' ? 'encoder' : one.what}: ${one.words}`);
  about.push(...found.notes);
  const { rows, bad_rows: bad, first_bad: first } = found.imported;
  if (bad) about.push(`${bad} of ${rows} rows cannot be used; the first is line ${first[0].line}: ${first[0].why}`);
  for (const one of found.findings) about.push(`${one.severity}: ${one.message}`);
  return about;
}

async function look(file, form = {}) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const mapping = $('mapping').files[0];
  const text = mapping ? await mapping.text() : '';
  const found = await program.document('look', file.name, bytes, JSON.stringify(form), text);
  if (found.kind === 'question') return question(file, form, found);
  const about = found.kind === 'log' ? aboutLog(found) : found.notes;
  const { mapping: saved, rejected } = found;
  for (const seen of found.runs) Object.assign(addRun(seen, about), { mapping: saved, rejected });
  showRuns();
  if (found.kind === 'log') proposeFit();
  say($('look-said'), `${file.name}: ${found.runs.length === 1 ? 'one run' : `${found.runs.length} runs`}`);
  return null;
}

/** The fields of missing facts. A reason may name a second one, as in `--position x:UNIT or --speed x:UNIT`. */
function fieldsOf(missing, form) {
  const fields = new Map();
  const add = (key, example, why) => FIELDS[key] && !fields.has(key) && fields.set(key, { example, why });
  for (const { key, example, why } of missing) {
    add(key, example, why.replace(/--([a-z-]+)/g, (flag, name) => FIELDS[name.replaceAll('-', '_')]?.[0] ?? flag));
    for (const [, name, value] of why.matchAll(/--([a-z-]+) (\S+)/g)) add(name.replaceAll('-', '_'), value, '');
  }
  for (const key of Object.keys(form)) add(key, '', '');
  return fields;
}

let asked = 0;
/** A field of the form with its label, its reason, and the proposed column in each unit. */
function field(key, { example, why }, value) {
  const [label, hint, units] = FIELDS[key];
  const id = `ask-${++asked}`;
  const isProposal = example.includes(':') && !example.startsWith('COLUMN');
  const column = example.slice(0, example.lastIndexOf(':'));
  const input = make('input', { id, name: key, value, placeholder: isProposal && !example.endsWith('UNIT') ? `such as ${example}` : hint, autocomplete: 'off', 'aria-describedby': `${id}-why` });
  if (isProposal && units) input.setAttribute('list', `${id}-units`);
  return make('p', {}, make('label', { htmlFor: id }, label), input,
    isProposal && units ? make('datalist', { id: `${id}-units` }, ...units.map((unit) => make('option', { value: `${column}:${unit}` }))) : null,
    make('span', { className: 'faint', id: `${id}-why` }, ...withCode(why)));
}

/** A form for the missing facts of a log. */
function question(file, form, found) {
  const box = make('form', { className: 'card' });
  const fields = fieldsOf(found.missing, form);
  const failure = make('p', { role: 'alert' });
  const recognised = found.understood.map((one) => `${one.what}: ${one.words}`).join('; ');
  box.append(
    make('h3', {}, `${file.name} lacks facts`),
    recognised ? make('p', { className: 'faint' }, make('span', {}, ...withCode(`Recognised: ${recognised}`))) : '',
    ...[...fields].map(([key, about]) => field(key, about, form[key] ?? '')),
    ...found.missing.filter((one) => !FIELDS[one.key]).map((one) => make('p', {}, make('span', {}, ...withCode(one.why)))),
    make('p', { className: 'row' }, make('button', { type: 'submit', className: 'main' }, 'Import'), make('button', { type: 'button', onclick: () => box.remove() }, 'Leave it out')),
    failure,
  );
  box.onsubmit = async (event) => {
    event.preventDefault();
    const said = Object.fromEntries([...box.querySelectorAll('input')].map((input) => [input.name, input.value]));
    try {
      await look(file, said);
      box.remove();
      for (const key of OF_BENCH) {
        for (const input of $('questions').querySelectorAll(`input[name=${key}]`)) input.value ||= said[key] ?? '';
      }
      $('questions').querySelector('input')?.focus();
    } catch (error) {
      say(failure, error.message, true);
    }
  };
  $('questions').append(box);
  say($('look-said'), `${file.name} lacks facts, which the form asks for`);
  box.querySelector('input')?.focus();
  return box;
}

async function take(files) {
  const failures = [];
  for (const file of files) {
    say($('look-said'), `reading ${file.name}`);
    try {
      await look(file);
    } catch (error) {
      failures.push(error.message);
    }
  }
  if (failures.length) say($('look-said'), failures.join('\n'), true);
}

$('files').onchange = () => take([...$('files').files]).then(() => ($('files').value = ''));
for (const kind of ['dragover', 'drop']) {
  document.addEventListener(kind, (event) => {
    event.preventDefault();
    if (kind === 'drop') take([...event.dataTransfer.files]);
  });
}
