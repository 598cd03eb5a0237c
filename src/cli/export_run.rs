//! `motorlab export parquet` and `export mcap`: a run for plotting and analysis programs.

use std::path::PathBuf;

use clap::Args;

#[cfg(any(feature = "parquet", feature = "mcap"))]
use super::foreign::unreadable;
use super::output_file::Force;
use super::{Failure, Output};
#[cfg(any(feature = "parquet", feature = "mcap"))]
use crate::hint::In;
use crate::plain::shown;
#[cfg(any(feature = "parquet", feature = "mcap"))]
use crate::recording::{Run, read_run};

/// Which run, and where it goes.
#[derive(Debug, Args)]
pub(super) struct RunFile {
    /// Run file.
    run: PathBuf,
    /// File to write. [default: the run's name with the format's ending]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

impl RunFile {
    #[cfg(feature = "parquet")]
    pub(super) fn parquet(&self, output: &Output) -> Result<PathBuf, Failure> {
        self.write(output, "parquet", |run, content| {
            crate::export::parquet::write_run(run, content).map_err(|error| error.to_string())
        })
    }

    /// As above, in a build without the feature.
    #[cfg(not(feature = "parquet"))]
    pub(super) fn parquet(&self, _: &Output) -> Result<PathBuf, Failure> {
        Err(not_built("parquet"))
    }

    #[cfg(feature = "mcap")]
    pub(super) fn mcap(&self, output: &Output) -> Result<PathBuf, Failure> {
        self.write(output, "mcap", |run, content| {
            let sink = std::io::Cursor::new(content);
            crate::export::mcap::write_run(run, sink).map_err(|error| error.to_string())
        })
    }

    /// As above, in a build without the feature.
    #[cfg(not(feature = "mcap"))]
    pub(super) fn mcap(&self, _: &Output) -> Result<PathBuf, Failure> {
        Err(not_built("mcap"))
    }

    #[cfg(any(feature = "parquet", feature = "mcap"))]
    fn write(
        &self,
        output: &Output,
        ending: &str,
        write: impl Fn(&Run, &mut Vec<u8>) -> Result<(), String>,
    ) -> Result<PathBuf, Failure> {
        let path = self.output.clone();
        let path = path.unwrap_or_else(|| self.run.with_extension(ending));
        let outputs = self.force.outputs("export", [&self.run]);
        outputs.check([&path])?;
        let (run, notes) = read_run(&self.run).map_err(|error| unreadable(&self.run, error))?;
        for note in notes {
            output.message(&format!("{}: {note}", shown(&self.run)));
        }
        let mut content = Vec::new();
        write(&run, &mut content).map_err(|error| {
            Failure::device(In::new(
                format!("cannot write {}", shown(&path)),
                std::io::Error::other(error),
            ))
        })?;
        outputs.write_bytes(&path, &content, None)?;
        Ok(path)
    }
}

/// Large formats are features of the build.
#[cfg(not(all(feature = "parquet", feature = "mcap")))]
pub(super) fn not_built(feature: &str) -> Failure {
    Failure::wrong(
        format!("this motorlab was built without the format {feature}"),
        format!("cargo install --path . --features {feature}"),
    )
    .of_kind("wrong_use")
}
