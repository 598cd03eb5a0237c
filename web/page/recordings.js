// Recordings: files that were dropped, what they lack, and the list of runs.
const runs = [];

const FIELDS = {
  time: ['Time', 'column:unit, as in t_ms:ms; or 10ms for rows 10 ms apart'],
  command: ['Command', 'column:unit (pwm, V, mV, percent); or 7V@0.95s'],
  command_limit: ['Limit of the command', 'a number'],
  direction: ['Direction', 'column, or column:number that is backwards; none'],
  position: ['Position', 'column:unit (counts, rev, rad, deg)'],
  speed: ['Speed', 'column:unit (rpm, rad/s, deg/s, counts/s)'],
  integrate: ['Speed is', 'backward, trapezoid or forward'],
  current: ['Current', 'column:unit (A, mA)'],
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
        run.about.length ? make('ul', { className: 'faint' }, ...run.about.map((text) => make('li', {}, text))) : null,
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
  say($('look-said'), `${file.name}: ${found.runs.length === 1 ? 'one run' : `${found.runs.length} runs`}`);
  return null;
}

let asked = 0;
/** A form that asks what a log lacks. */
function question(file, form, found) {
  const box = make('form', { className: 'card' });
  const id = `ask${++asked}`;
  const fields = [...new Set([...found.missing.map((one) => one.key), ...Object.keys(form)])].filter((key) => FIELDS[key]);
  const inputs = Object.fromEntries(fields.map((key) => [key, make('input', { id: `${id}-${key}`, name: key, value: form[key] ?? '', placeholder: FIELDS[key][1] })]));
  const failure = make('p', { role: 'alert' });
  box.append(
    make('h3', {}, `${file.name} lacks facts`),
    found.understood.length ? make('p', { className: 'faint' }, 'Recognised: ', found.understood.map((one) => `${one.what}: ${one.words}`).join('; ')) : '',
    ...fields.map((key) => {
      const why = found.missing.find((one) => one.key === key)?.why ?? '';
      inputs[key].setAttribute('aria-describedby', `${id}-why-${key}`);
      return make('p', {}, make('label', { htmlFor: inputs[key].id }, FIELDS[key][0]), inputs[key], make('span', { className: 'faint', id: `${id}-why-${key}` }, why));
    }),
    ...found.missing.filter((one) => !FIELDS[one.key]).map((one) => make('p', {}, one.why)),
    make('p', { className: 'row' }, make('button', { type: 'submit', className: 'main' }, 'Import'), make('button', { type: 'button', onclick: () => box.remove() }, 'Leave it out')),
    failure,
  );
  box.onsubmit = async (event) => {
    event.preventDefault();
    const said = Object.fromEntries(fields.map((key) => [key, inputs[key].value]));
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
  inputs[fields[0]]?.focus();
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
