// The motor: the handout's, values of a form, of a data sheet or of a file, or a fitted one. SI inside, other units in the forms.
const RPM = (2 * Math.PI) / 60;
// Names, default in SI, and units with their factor to SI.
const TORQUES = { 'N m': 1, 'N cm': 0.01, 'mN m': 0.001, 'kg cm': 0.0980665, 'oz in': 0.00706155 };
const INERTIAS = { 'kg m²': 1, 'kg cm²': 1e-4, 'g cm²': 1e-7 };
const INDUCTANCES = { mH: 1e-3, H: 1, 'µH': 1e-6 };
const PARAMETERS = {
  resistance_ohm: ['Armature resistance R', { 'Ω': 1 }],
  back_emf_v_s_per_rad: ['Back-EMF constant Kb', { 'V s/rad': 1, 'V/1000 rpm': 0.001 / RPM, 'mV/rpm': 0.001 / RPM }],
  torque_constant_nm_per_a: ['Torque constant Kt', { 'N m/A': 1, 'mN m/A': 0.001, 'N cm/A': 0.01, 'oz in/A': 0.00706155 }],
  viscous_friction_nm_s_per_rad: ['Viscous friction b', { 'N m s/rad': 1, 'N m/rpm': 1 / RPM }],
  inductance_h: ['Armature inductance L', INDUCTANCES],
  inertia_kg_m2: ['Inertia J of rotor, gear and load', INERTIAS],
  coulomb_friction_nm: ['Coulomb friction Tf', TORQUES],
  counts_per_rev: ['Counts per revolution', { counts: 1 }],
  supply_v: ['Supply', { V: 1 }],
};
const SHEET = {
  voltage_v: ['Nominal voltage', { V: 1 }, 12],
  no_load_speed_rad_s: ['Speed without load', { rpm: RPM, 'rad/s': 1 }, 500 * RPM],
  no_load_current_a: ['Current without load', { A: 1, mA: 0.001 }, 0.15],
  stall_torque_nm: ['Stall torque', TORQUES, 0.6],
  stall_current_a: ['Stall current', { A: 1, mA: 0.001 }, 2],
  inertia_kg_m2: ['Inertia of rotor, gear and load', INERTIAS, 1e-4],
  inductance_h: ['Inductance', INDUCTANCES, 0.002],
  counts_per_rev: ['Counts per revolution', { counts: 1 }, 1200],
  supply_v: ['Supply of the driver', { V: 1 }, 12],
};

/** A field of a number with its unit; `read()` returns its value in SI. */
function quantity(prefix, key, [label, units], value) {
  const input = make('input', { id: `${prefix}-${key}`, inputMode: 'decimal', autocomplete: 'off' });
  const names = Object.keys(units);
  const unit = names.length > 1
    ? make('select', { 'aria-label': `Unit of ${label}` }, ...names.map((name) => make('option', { value: name }, name)))
    : make('span', { className: 'faint' }, names[0]);
  const factor = () => units[unit.value ?? names[0]];
  let before = factor();
  input.value = shown(value / before);
  unit.onchange = () => {
    // The same quantity in another unit.
    if (input.value !== '') input.value = shown((Number(input.value) * before) / factor());
    before = factor();
  };
  return {
    row: make('p', { className: 'quantity' }, make('label', { htmlFor: input.id }, label), input, unit),
    read: () => Number(input.value.replace(',', '.')) * factor(),
    label,
    input,
  };
}

let formFields = {};
let sheetFields = {};
let motorFileText = '';

function layMotorForms(handout) {
  formFields = Object.fromEntries(Object.entries(PARAMETERS).map(([key, about]) => [key, quantity('motor', key, about, handout[key])]));
  sheetFields = Object.fromEntries(Object.entries(SHEET).map(([key, about]) => [key, quantity('sheet', key, about, about[2])]));
  $('motor-form').replaceChildren(...Object.values(formFields).map((field) => field.row));
  $('motor-sheet').replaceChildren(...Object.values(sheetFields).map((field) => field.row));
}

const motorKind = () => document.querySelector('input[name=motor]:checked').value;

function showMotor() {
  for (const kind of ['form', 'sheet', 'file']) $(`motor-${kind}`).hidden = motorKind() !== kind;
  $('save-motor').hidden = motorKind() === 'fit';
  say($('motor-said'), '');
}

function numbers(fields) {
  const values = {};
  for (const [key, field] of Object.entries(fields)) {
    values[key] = field.read();
    if (!Number.isFinite(values[key]) || field.input.value.trim() === '') {
      field.input.focus();
      throw new Hinted(`${field.label}: '${field.input.value}' is no number`, 'enter digits with a point or a comma, without the unit');
    }
  }
  return JSON.stringify(values);
}

/** The motor of a question: a motor file, nothing for the handout's motor, or a fit. */
async function motorAsked() {
  switch (motorKind()) {
    case 'form':
      return { motor: await program.ask('motor_file', numbers(formFields)) };
    case 'sheet':
      return { motor: await program.ask('motor_of_data_sheet', numbers(sheetFields)) };
    case 'file':
      if (!motorFileText) throw new Hinted('Motor: no file is chosen', 'choose a motor file, or another motor above');
      return { motor: motorFileText };
    case 'fit':
      return { fit: true };
    default:
      return { fit: false };
  }
}

let isMotorChosen = false;
document.querySelectorAll('input[name=motor]').forEach((choice) => (choice.onchange = () => {
  isMotorChosen = true;
  showMotor();
}));

function chooseHandout() {
  document.querySelector('input[name=motor][value=handout]').checked = true;
  showMotor();
}

/** The motor of a foreign log is unknown: as in the program, it is fitted unless another is chosen. */
function proposeFit() {
  if (isMotorChosen) return;
  document.querySelector('input[name=motor][value=fit]').checked = true;
  showMotor();
  say($('motor-said'), 'The log does not describe its motor: it is fitted to the recordings, unless you choose another.');
}
$('motor-file-input').onchange = async () => {
  const file = $('motor-file-input').files[0];
  if (!file) return;
  const text = await file.text();
  try {
    await program.ask('offered', text);
    motorFileText = text;
    say($('motor-said'), `${file.name} is read`);
  } catch (error) {
    motorFileText = '';
    say($('motor-said'), `${file.name}: ${error.message}`, true);
  }
};
$('save-motor').onclick = async () => {
  try {
    const { motor } = await motorAsked();
    const text = motor ?? (await program.ask('motor_file', JSON.stringify((await offers).parameters)));
    download('motor.toml', text, 'text/plain');
  } catch (error) {
    say($('motor-said'), error.message, true);
  }
};
