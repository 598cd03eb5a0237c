//! URDF: a continuous joint with `<dynamics damping friction>`, its link's inertia, and the motor's limits.
//!
//! URDF has no actuator: back EMF acts through whatever drives the joint. Its equivalent damping at a constant
//! voltage, `Kt Kb / R`, is in the comment.

use super::mujoco::commented;
use super::{ExportError, Linear};
use crate::motor::Motor;
use crate::motor::catalogue::ids;

/// Effects that change only a coefficient of the joint and its link.
pub const EXPRESSED: [&str; 3] = [ids::COULOMB_FRICTION, ids::VISCOUS_FRICTION, ids::INERTIA];

/// The motor's shaft as a URDF robot of two links.
///
/// # Errors
/// Effects without an attribute of the joint, unless `leave_out`.
pub fn model(motor: &Motor, leave_out: bool) -> Result<String, ExportError> {
    let linear = Linear::of(motor, "URDF's joint", &EXPRESSED, leave_out)?;
    let p = &linear.parameters;
    let (r, kt, kb, b) = (
        p.resistance_ohm,
        p.torque_constant_nm_per_a,
        p.back_emf_v_s_per_rad,
        p.viscous_friction_nm_s_per_rad,
    );
    let stall_nm = kt * p.supply_v / r;
    let back_emf = kt * kb / r;
    let fastest = ((stall_nm - p.coulomb_friction_nm) / (b + back_emf)).max(0.0);
    // Without damping there is no steady speed, and a continuous joint needs no limit.
    let limit = if fastest.is_finite() {
        format!("    <limit effort=\"{stall_nm}\" velocity=\"{fastest}\"/>\n")
    } else {
        String::new()
    };
    let assumed = commented(&motor.assumptions());
    let remarks = commented(&linear.remarks());
    Ok(format!(
        "<?xml version=\"1.0\"?>\n\
         <!-- DC motor, SI units: angle rad, speed w rad/s, torque N m.\n\
         {assumed}\
         \x20      J dw/dt = torque - damping w - friction sgn(w)\n\
         \x20      izz = J (kg m^2), damping = b (N m s/rad), friction = Tf (N m)\n\
         \x20      effort = stall torque Kt V / R (N m), velocity = steady speed at V = {v} V (rad/s)\n\
         \x20      URDF has no voltage: the torque of a motor held at u volts is Kt (u - Kb w) / R,\n\
         \x20      u/V times the effort less {back_emf} N m s/rad times w, which the program that drives the joint must add.\n\
         {remarks}-->\n\
         <robot name=\"dc_motor\">\n\
         \x20 <link name=\"base\"/>\n\
         \x20 <link name=\"shaft\">\n\
         \x20   <inertial>\n\
         \x20     <mass value=\"1e-3\"/>\n\
         \x20     <inertia ixx=\"{j}\" ixy=\"0\" ixz=\"0\" iyy=\"{j}\" iyz=\"0\" izz=\"{j}\"/>\n\
         \x20   </inertial>\n\
         \x20 </link>\n\
         \x20 <joint name=\"motor\" type=\"continuous\">\n\
         \x20   <parent link=\"base\"/>\n\
         \x20   <child link=\"shaft\"/>\n\
         \x20   <axis xyz=\"0 0 1\"/>\n\
         {limit}\
         \x20   <dynamics damping=\"{b}\" friction=\"{tf}\"/>\n\
         \x20 </joint>\n\
         </robot>\n",
        v = p.supply_v,
        j = p.inertia_kg_m2,
        tf = p.coulomb_friction_nm,
    ))
}
