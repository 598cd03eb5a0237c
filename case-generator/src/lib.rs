//! Makes recordings of imagined motors, apart from the simulator that diagnoses them.
