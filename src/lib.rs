//! motorlab.
