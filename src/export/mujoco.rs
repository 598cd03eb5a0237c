//! MuJoCo (MJCF): a hinge with the rotor's inertia as armature, and a general actuator with back EMF.
//!
//! With `gainprm = g Kt / R` and `biasprm = 0 0 -Kt Kb / R` the actuator's torque is `Kt (g u - Kb w) / R`: the motor
//! with L = 0. `frictionloss` is Tf, `damping` is b.

use super::actuator::output_inertia;
use super::{ExportError, Linear};
use crate::motor::Motor;
use crate::motor::catalogue::ids;

/// Effects that change only a coefficient of hinge and actuator.
pub const EXPRESSED: [&str; 5] = [
    ids::COULOMB_FRICTION,
    ids::VISCOUS_FRICTION,
    ids::INERTIA,
    ids::SUPPLY_ERROR,
    ids::CURRENT_LIMIT,
];

/// Time step of the model, in s.
pub const TIME_STEP_S: f64 = 0.001;

/// A hinge with the output shaft's inertia, and an actuator whose torque MuJoCo gets from a Python module.
pub fn called_model(motor: &Motor, module: &str) -> String {
    let assumed = commented(&motor.assumptions());
    format!(
        "<!-- DC motor, SI units: angle rad, speed rad/s, torque N m, control in V.\n\
         {assumed}\
         \x20      Its torque, with friction and all effects, comes from the Python module {name}:\n\
         \x20      import it, and call install(model) after loading this file. Without it the actuator does nothing.\n\
         \x20      armature = inertia of the output shaft (kg m^2); the joint itself has no friction and no damping.\n\
         -->\n\
         <mujoco model=\"dc_motor\">\n\
         \x20 <compiler angle=\"radian\"/>\n\
         \x20 <option timestep=\"{TIME_STEP_S}\" integrator=\"implicitfast\" gravity=\"0 0 0\"/>\n\
         \x20 <worldbody>\n\
         \x20   <body name=\"shaft\">\n\
         \x20     <inertial pos=\"0 0 0\" mass=\"1e-6\" diaginertia=\"1e-12 1e-12 1e-12\"/>\n\
         \x20     <joint name=\"motor\" type=\"hinge\" axis=\"0 0 1\" armature=\"{inertia}\"/>\n\
         \x20   </body>\n\
         \x20 </worldbody>\n\
         \x20 <actuator>\n\
         \x20   <general name=\"voltage\" joint=\"motor\" ctrllimited=\"true\" ctrlrange=\"{low} {supply}\" \
         gaintype=\"fixed\" gainprm=\"0\" biastype=\"user\"/>\n\
         \x20 </actuator>\n\
         \x20 <sensor>\n\
         \x20   <jointpos name=\"angle\" joint=\"motor\"/>\n\
         \x20   <jointvel name=\"speed\" joint=\"motor\"/>\n\
         \x20 </sensor>\n\
         </mujoco>\n",
        name = spaced(module),
        inertia = output_inertia(motor),
        low = -motor.parameters.supply_v,
        supply = motor.parameters.supply_v,
    )
}

/// A text for an XML comment, which may not contain two hyphens.
pub(super) fn spaced(text: &str) -> String {
    text.replace("--", "- -")
}

/// Lines of an XML comment.
pub(super) fn commented(lines: &[String]) -> String {
    lines.iter().fold(String::new(), |text, line| {
        text + "       " + &spaced(line) + "\n"
    })
}

/// The motor as an MJCF model.
///
/// # Errors
/// Effects without an attribute of joint or actuator, unless `leave_out`.
pub fn model(motor: &Motor, leave_out: bool) -> Result<String, ExportError> {
    let linear = Linear::of(
        motor,
        "MuJoCo's joint and general actuator",
        &EXPRESSED,
        leave_out,
    )?;
    let p = &linear.parameters;
    let (r, kt, kb) = (
        p.resistance_ohm,
        p.torque_constant_nm_per_a,
        p.back_emf_v_s_per_rad,
    );
    let assumed = commented(&motor.assumptions());
    let remarks = commented(&linear.remarks());
    let force = linear.current_limit_a.map_or(String::new(), |limit_a| {
        format!(
            " forcelimited=\"true\" forcerange=\"{0} {1}\"",
            -kt * limit_a,
            kt * limit_a
        )
    });
    Ok(format!(
        "<!-- DC motor, SI units: angle rad, speed w rad/s, torque N m, control u in V.\n\
         {assumed}\
         \x20      (J) dw/dt = torque - b w - Tf sgn(w),  torque = gain u + bias w\n\
         \x20      armature = J (kg m^2), damping = b (N m s/rad), frictionloss = Tf (N m)\n\
         \x20      gainprm = Kt / R (N m/V){gain_note}, biasprm = 0 0 -Kt Kb / R (N m s/rad)\n\
         \x20      forcerange = Kt times the current limit (N m), where there is one\n\
         \x20      The encoder is no part of this model: {counts} counts a revolution.\n\
         {remarks}-->\n\
         <mujoco model=\"dc_motor\">\n\
         \x20 <compiler angle=\"radian\"/>\n\
         \x20 <option timestep=\"{TIME_STEP_S}\" integrator=\"implicitfast\" gravity=\"0 0 0\"/>\n\
         \x20 <worldbody>\n\
         \x20   <body name=\"shaft\">\n\
         \x20     <inertial pos=\"0 0 0\" mass=\"1e-6\" diaginertia=\"1e-12 1e-12 1e-12\"/>\n\
         \x20     <joint name=\"motor\" type=\"hinge\" axis=\"0 0 1\" armature=\"{j}\" damping=\"{b}\" frictionloss=\"{tf}\"/>\n\
         \x20   </body>\n\
         \x20 </worldbody>\n\
         \x20 <actuator>\n\
         \x20   <general name=\"voltage\" joint=\"motor\" ctrllimited=\"true\" ctrlrange=\"{low} {v}\" \
         gaintype=\"fixed\" gainprm=\"{gain}\" biastype=\"affine\" biasprm=\"0 0 {bias}\"{force}/>\n\
         \x20 </actuator>\n\
         \x20 <sensor>\n\
         \x20   <jointpos name=\"angle\" joint=\"motor\"/>\n\
         \x20   <jointvel name=\"speed\" joint=\"motor\"/>\n\
         \x20 </sensor>\n\
         </mujoco>\n",
        gain_note = if linear.gain == 1.0 {
            String::new()
        } else {
            format!(" times the supply's gain {}", linear.gain)
        },
        counts = p.counts_per_rev,
        j = p.inertia_kg_m2,
        b = p.viscous_friction_nm_s_per_rad,
        tf = p.coulomb_friction_nm,
        low = -p.supply_v,
        v = p.supply_v,
        gain = linear.gain * kt / r,
        bias = -kt * kb / r,
    ))
}
