//! MAT-files of version 5 (`save -v6`, `save -v7` without compression), as MATLAB and Octave load them.
//!
//! A header of 128 bytes, then one `miMATRIX` element per variable: array flags, dimensions, name, data; every
//! element begins with type and length and is padded to 8 bytes. Little-endian. After MathWorks, "MAT-File Format",
//! chapter 1 (Level 5).

use crate::recording::Run;

const MI_INT8: u32 = 1;
const MI_UINT16: u32 = 4;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_MATRIX: u32 = 14;

const MX_CHAR: u32 = 4;
const MX_DOUBLE: u32 = 6;

/// A MAT-file under construction.
#[derive(Debug, Clone)]
pub struct MatFile {
    bytes: Vec<u8>,
}

/// A value that a MAT-file cannot hold.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MatError {
    /// An element of a MAT-file of version 5 is at most 2 GiB.
    #[error(
        "{name} has {samples} samples, more than a MAT-file of version 5 holds in one variable\nhint: export a shorter run, or as Parquet: motorlab export parquet RUN"
    )]
    TooLong {
        /// The variable.
        name: String,
        /// Its length.
        samples: usize,
    },
}

/// Most doubles in one variable, with room for its header.
const MOST_DOUBLES: usize = (i32::MAX as usize - 4096) / 8;

impl Default for MatFile {
    fn default() -> Self {
        let mut text = format!(
            "MATLAB 5.0 MAT-file, written by motorlab export, {}",
            env!("CARGO_PKG_VERSION")
        )
        .into_bytes();
        text.resize(116, b' ');
        text.extend([0; 8]);
        text.extend(0x0100_u16.to_le_bytes());
        text.extend(*b"IM");
        Self { bytes: text }
    }
}

impl MatFile {
    /// A column of doubles.
    ///
    /// # Errors
    /// The column is longer than the format holds.
    pub fn column(&mut self, name: &str, values: &[f64]) -> Result<(), MatError> {
        if values.len() > MOST_DOUBLES {
            return Err(MatError::TooLong {
                name: name.to_owned(),
                samples: values.len(),
            });
        }
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.matrix(name, MX_DOUBLE, [values.len(), 1], MI_DOUBLE, &data);
        Ok(())
    }

    /// One number.
    pub fn scalar(&mut self, name: &str, value: f64) {
        self.matrix(name, MX_DOUBLE, [1, 1], MI_DOUBLE, &value.to_le_bytes());
    }

    /// A line of text.
    pub fn text(&mut self, name: &str, text: &str) {
        let units: Vec<u16> = text.encode_utf16().collect();
        let data: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let rows = usize::from(!units.is_empty());
        self.matrix(name, MX_CHAR, [rows, units.len()], MI_UINT16, &data);
    }

    /// The file's bytes.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }

    fn matrix(&mut self, name: &str, class: u32, dimensions: [usize; 2], kind: u32, data: &[u8]) {
        let mut body = Vec::with_capacity(data.len() + name.len() + 64);
        let flags: Vec<u8> = [class, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
        element(&mut body, MI_UINT32, &flags);
        let sizes: Vec<u8> = dimensions
            .iter()
            .flat_map(|&size| (size as i32).to_le_bytes())
            .collect();
        element(&mut body, MI_INT32, &sizes);
        element(&mut body, MI_INT8, name.as_bytes());
        element(&mut body, kind, data);
        element(&mut self.bytes, MI_MATRIX, &body);
    }
}

/// One data element: type, length, data, padding to 8 bytes.
fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
}

/// A run: one variable per column under the run file's names, its sample time, resolution and header.
///
/// Counts above 2^53, which a double does not represent exactly, take 250 years of an encoder at 1 MHz.
///
/// # Errors
/// The run is longer than the format holds.
pub fn of_run(run: &Run) -> Result<Vec<u8>, MatError> {
    let mut file = MatFile::default();
    file.scalar("TS", run.sample_time_s);
    file.scalar("encoder_counts", run.counts_per_rev);
    if let Some(supply_v) = run.supply_v {
        file.scalar("Vsupply", supply_v);
    }
    file.column("t_s", &run.t_s)?;
    file.column(run.command_kind.column(), &run.command)?;
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    file.column("counts", &counts)?;
    if let Some(seq) = &run.seq {
        let seq: Vec<f64> = seq.iter().map(|&n| n as f64).collect();
        file.column("seq", &seq)?;
    }
    if let Some(speeds) = &run.velocity_rad_s {
        let speeds: Vec<f64> = speeds.iter().map(|w| w.unwrap_or(f64::NAN)).collect();
        file.column("velocity_rad_s", &speeds)?;
    }
    let measured = [
        ("host_t_s", &run.host_t_s),
        ("supply_v", &run.measured_supply_v),
        ("current_a", &run.measured_current_a),
    ];
    for (name, column) in measured {
        if let Some(column) = column {
            file.column(name, column)?;
        }
    }
    file.text("header_toml", &run.header.to_string());
    Ok(file.finish())
}
