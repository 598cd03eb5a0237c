//! `--motor` and the handout's models: options shared by several subcommands.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::motor_file::motor_file;
use super::{Failure, Output};
use crate::motor::{Model, Motor};

#[derive(Debug, Clone, Args)]
pub(super) struct MotorChoice {
    /// Motor file; without it the lab handout's motor.
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
    /// Order of the model: without (first-order) or with the winding's inductance.
    #[arg(long, value_enum, default_value_t = Order::SecondOrder)]
    model: Order,
    /// Leave out Coulomb friction (viscous friction only).
    #[arg(long)]
    no_coulomb: bool,
    /// Leave out all friction.
    #[arg(long)]
    no_friction: bool,
}

/// Order of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Order {
    /// L = 0: the current follows the voltage at once.
    FirstOrder,
    /// With the inductance of the motor file.
    SecondOrder,
}

impl MotorChoice {
    pub(super) fn file(&self) -> Option<&PathBuf> {
        self.motor.as_ref()
    }

    /// The motor without the excluded friction, and a message if it is the default one.
    pub(super) fn motor(&self, output: &Output) -> Result<Motor, Failure> {
        self.print_default(output);
        self.motor_without_message(output)
    }

    /// Prints that the handout's motor is simulated if none is given.
    pub(super) fn print_default(&self, output: &Output) {
        if self.motor.is_none() {
            output.message("no --motor: the lab handout's motor is simulated");
        }
    }

    /// The same motor without the message about the default, which a fit may replace.
    pub(super) fn motor_without_message(&self, output: &Output) -> Result<Motor, Failure> {
        let mut motor = match &self.motor {
            Some(path) => motor_file(path, output)?,
            None => Motor::default(),
        };
        if self.no_coulomb || self.no_friction {
            motor.parameters.coulomb_friction_nm = 0.0;
        }
        if self.no_friction {
            motor.parameters.viscous_friction_nm_s_per_rad = 0.0;
        }
        Ok(motor)
    }

    pub(super) fn is_given(&self) -> bool {
        self.motor.is_some()
    }

    pub(super) fn model(&self) -> Model {
        match self.model {
            Order::FirstOrder => Model::FirstOrder,
            Order::SecondOrder => Model::SecondOrder,
        }
    }

    pub(super) fn words(&self) -> &'static str {
        match (self.model, self.no_friction, self.no_coulomb) {
            (Order::FirstOrder, true, _) => "first order, no friction",
            (Order::FirstOrder, false, true) => "first order, viscous friction",
            (Order::FirstOrder, false, false) => "first order, viscous and Coulomb friction",
            (Order::SecondOrder, true, _) => "second order, no friction",
            (Order::SecondOrder, false, true) => "second order, viscous friction",
            (Order::SecondOrder, false, false) => "second order, viscous and Coulomb friction",
        }
    }
}
