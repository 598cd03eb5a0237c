// Try it: the virtual board with effects of the catalogue, known or hidden.
let offers;
let hidden;

/** A summary of the catalogue as a sentence. */
const sentence = (text) => `${text[0].toUpperCase()}${text.slice(1).replace(/\.?$/, '.')}`;

function describe(entry) {
  $('effect-summary').replaceChildren(sentence(entry.summary), make('br'), make('code', {}, entry.equation));
  $('effect-numbers').replaceChildren(
    ...entry.parameters.map((number) => {
      const id = `effect-${number.key}`;
      const output = make('output', { htmlFor: id });
      const [lo, hi] = number.one_of ? [0, number.one_of.length - 1] : [number.lo, number.hi];
      const at = number.one_of ? Math.max(0, number.one_of.indexOf(number.default)) : number.default;
      const slider = make('input', { id, type: 'range', min: lo, max: hi, step: number.one_of ? 1 : 'any', value: at });
      const value = () => (number.one_of ? number.one_of[Number(slider.value)] : Number(slider.value));
      const show = () => (output.textContent = `${shown(value())} ${number.unit}`);
      slider.oninput = show;
      slider.dataset.key = number.key;
      slider.read = value;
      show();
      return make('p', { className: 'quantity' }, make('label', { htmlFor: id }, number.key.replaceAll('_', ' ')), slider, output);
    }),
  );
}

const entryOf = async (id) => (await offers).effects.find((entry) => entry.effect === id);

async function layOffers() {
  const told = await offers;
  layMotorForms(told.parameters);
  $('profile').replaceChildren(...told.profiles.map(([name, what]) => make('option', { value: name }, `${name}: ${what}`)));
  $('profile').value = 'reversing';
  const stages = [...new Set(told.effects.map((entry) => entry.stage))];
  $('effect').replaceChildren(
    ...stages.map((stage) => {
      const of = told.effects.filter((entry) => entry.stage === stage);
      return make('optgroup', { label: stage }, ...of.map((entry) => make('option', { value: entry.effect }, entry.effect.replaceAll('_', ' '))));
    }),
  );
  $('effect').value = 'backlash';
  describe(await entryOf('backlash'));
  document.documentElement.dataset.ready = 'yes';
}

/** Records from a virtual board whose motor has effects that the chosen motor lacks. */
async function recordWith(effects, experiment, name, next) {
  let motor;
  try {
    motor = await program.ask('motor_with_effects', await motorOfBench(), JSON.stringify(effects));
  } catch (error) {
    say($('record-said'), error.message, true);
    return undefined;
  }
  const { profile, duration_s: duration, sample_time_s: sample } = experiment;
  const order = { profile, duration_s: duration, sample_time_s: sample, source: { kind: 'virtual', motor, seed: 7, fast: true } };
  for (const run of runs) run.isChosen = false;
  const run = await recordRun(order, name);
  if (run) {
    // The present answer is about another recording.
    $('answer').replaceChildren();
    say($('answer-said'), next);
    $('ask').scrollIntoView();
    $('diagnose').focus();
  }
  return run;
}

$('effect').onchange = async () => describe(await entryOf($('effect').value));
$('try').onclick = async () => {
  const entry = await entryOf($('effect').value);
  const numbers = [...$('effect-numbers').querySelectorAll('input')].map((slider) => [slider.dataset.key, slider.read()]);
  await recordWith([{ effect: entry.effect, numbers }], entry.experiment, `${entry.effect}.csv`, `A board with ${entry.effect.replaceAll('_', ' ')} is recorded. Diagnose tells what a simulation without it lacks.`);
};
$('hide').onclick = async () => {
  const told = await offers;
  // Only effects that a recording separates from the motor's parameters.
  const fair = told.effects.filter((entry) => !entry.twin && !entry.random);
  hidden = fair[crypto.getRandomValues(new Uint32Array(1))[0] % fair.length];
  $('reveal').hidden = true;
  say($('hidden-said'), '');
  const next = 'A board with a hidden effect is recorded. Guess from the picture of the recording, let Diagnose find it, and reveal it under Try it.';
  if (await recordWith([{ effect: hidden.effect }], hidden.experiment, 'hidden.csv', next)) $('reveal').hidden = false;
};
$('reveal').onclick = () => say($('hidden-said'), `Hidden: ${hidden.effect.replaceAll('_', ' ')}. ${sentence(hidden.summary)}`);
// The example of the README: a driver that drops voltage, diagnosed with the handout's motor.
$('example').onclick = async () => {
  chooseHandout();
  const experiment = { profile: 'reversing', duration_s: 6, sample_time_s: 0.003 };
  await recordWith([{ effect: 'voltage_drop', numbers: [['drop_v', 0.8]] }], experiment, 'example.csv', 'The example is recorded. Press Diagnose.');
};

// The program for the console, and for tests.
window.motorlab = program;

offers = program.document('offered', '');
offers.then(layOffers).catch((error) => say($('look-said'), error.message.includes('hint:') ? error.message : `${error.message}\nhint: load the page in a current version of Chrome, Edge, Firefox or Safari`, true));
showRuns();
showMotor();
showSource();
