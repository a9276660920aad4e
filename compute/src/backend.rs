//! Choosing who draws.

use std::sync::Arc;

use crate::cpu::CpuRows;
use crate::gpu::{AdapterChoice, GpuRows};
use crate::hemicubes::Hemicubes;
use crate::rows::{BackendError, RowSource};
use crate::settings::BackendChoice;

/// An opened back end and its name, `cpu` or `gpu`.
pub struct Backend<'a> {
    /// As on the command line.
    pub name: &'static str,
    /// Draws the rows.
    pub source: Box<dyn RowSource + 'a>,
    /// Something the user should know about the choice.
    pub remark: Option<String>,
}

/// Opens the back end that was asked for.
///
/// `auto` falls back to the CPU where there is no real GPU, or none that will do.
pub fn open<'a>(
    hemicubes: &Arc<Hemicubes<'a>>,
    choice: BackendChoice,
) -> Result<Backend<'a>, BackendError> {
    let cpu = |remark| Backend {
        name: "cpu",
        source: Box::new(CpuRows::new(hemicubes)),
        remark,
    };
    let gpu = |adapters| {
        GpuRows::new(hemicubes, adapters).map(|rows| Backend {
            name: "gpu",
            source: Box::new(rows),
            remark: None,
        })
    };
    match choice {
        BackendChoice::Cpu => Ok(cpu(None)),
        BackendChoice::Gpu => gpu(AdapterChoice::Any),
        BackendChoice::Auto => Ok(match gpu(AdapterChoice::RealOnly) {
            Ok(backend) => backend,
            Err(BackendError::NoAdapter) => cpu(None),
            Err(error) => cpu(Some(format!("the GPU is not used: {error}"))),
        }),
    }
}
