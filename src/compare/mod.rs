//! Recorded against simulated: the overlay and its figures.
