//! Choosing who draws.

use std::sync::Arc;

use crate::cpu::CpuRows;
use crate::hemicubes::Hemicubes;
use crate::rows::{BackendError, RowSource};
use crate::settings::{AdapterChoice, BackendChoice};

/// An opened back end.
pub struct Backend<'a> {
    /// Draws the rows.
    pub source: Box<dyn RowSource + 'a>,
    /// Something the user should know about the choice.
    pub remark: Option<String>,
}

/// Opens the back end that was asked for.
///
/// `auto` falls back to the CPU where there is no real GPU, or none that will do.
///
/// # Errors
/// An adapter that was asked for and is missing, or that will not do.
pub fn open<'a>(
    hemicubes: &Arc<Hemicubes<'a>>,
    choice: BackendChoice,
) -> Result<Backend<'a>, BackendError> {
    let cpu = |remark| Backend {
        source: Box::new(CpuRows::new(hemicubes)),
        remark,
    };
    match choice {
        BackendChoice::Cpu => Ok(cpu(None)),
        BackendChoice::Gpu => Ok(Backend {
            source: gpu(hemicubes, AdapterChoice::Any)?,
            remark: None,
        }),
        BackendChoice::Auto => Ok(match gpu(hemicubes, AdapterChoice::RealOnly) {
            Ok(source) => Backend {
                source,
                remark: None,
            },
            Err(BackendError::NoAdapter) => cpu(None),
            Err(error) => cpu(Some(format!("the GPU is not used: {error}"))),
        }),
    }
}

#[cfg(feature = "gpu")]
fn gpu<'a>(
    hemicubes: &Arc<Hemicubes<'a>>,
    adapters: AdapterChoice,
) -> Result<Box<dyn RowSource + 'a>, BackendError> {
    Ok(Box::new(crate::gpu::GpuRows::new(hemicubes, adapters)?))
}

/// Without the gpu back end there is no adapter.
#[cfg(not(feature = "gpu"))]
fn gpu<'a>(
    _: &Arc<Hemicubes<'a>>,
    _: AdapterChoice,
) -> Result<Box<dyn RowSource + 'a>, BackendError> {
    Err(BackendError::NoAdapter)
}
