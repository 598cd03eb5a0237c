//! The Arduino sketch that implements this protocol, as files.

/// Name and text of each file in the sketch's folder, which must be called `motorlab`.
pub const FILES: [(&str, &str); 9] = [
    (
        "motorlab.ino",
        include_str!("../arduino/motorlab/motorlab.ino"),
    ),
    ("settings.h", include_str!("../arduino/motorlab/settings.h")),
    (
        "motorlab_wire.h",
        include_str!("../arduino/motorlab/motorlab_wire.h"),
    ),
    ("frames.h", include_str!("../arduino/motorlab/frames.h")),
    ("encoder.h", include_str!("../arduino/motorlab/encoder.h")),
    ("drive.h", include_str!("../arduino/motorlab/drive.h")),
    ("sampler.h", include_str!("../arduino/motorlab/sampler.h")),
    ("README.md", include_str!("../arduino/motorlab/README.md")),
    ("wiring.svg", include_str!("../arduino/motorlab/wiring.svg")),
];
