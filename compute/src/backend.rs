//! Choosing who draws.
//!
//! A GPU is not faster because it is there, and its driver may draw something else. So a few hemicubes of the scene are
//! drawn on both ([`Trial`]): `auto` takes a GPU that draws the same rows and is faster, and says why it does not take
//! another one; a GPU that was asked for draws in any case, with a warning where its rows are others. A run that goes on
//! keeps the back end of its file ([`RowOrigin`]) without another trial, since it is to have the same bits.

pub mod agreement;
mod origin;
#[cfg(test)]
mod tests;
pub mod trial;

use std::sync::Arc;

use crate::cpu::CpuRows;
use crate::hemicubes::Hemicubes;
use crate::rows::{BackendError, RowSource};
use crate::settings::{AdapterChoice, BackendChoice, Drawing};

pub use origin::{Drawer, RowOrigin};
pub use trial::Trial;

/// An opened back end.
pub struct Backend<'a> {
    /// Draws the rows.
    pub source: Box<dyn RowSource + 'a>,
    /// How it was chosen.
    pub choice: Choice,
}

/// How a back end was chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// Something the user should know about it.
    pub remark: Option<String>,
    /// What was measured; `None` where there was nothing to choose or to warn of.
    pub trial: Option<Trial>,
}

impl<'a> Backend<'a> {
    /// One of which there is nothing to tell.
    pub fn without_choice(source: Box<dyn RowSource + 'a>) -> Self {
        Self {
            source,
            choice: Choice::default(),
        }
    }
}

/// Opens the back end that was asked for.
///
/// `auto` falls back to the CPU where there is no real GPU, or none that will do.
///
/// # Errors
/// An adapter that was asked for and is missing, or that will not do.
pub fn open<'a>(
    hemicubes: &Arc<Hemicubes<'a>>,
    drawing: Drawing,
) -> Result<Backend<'a>, BackendError> {
    let cpu = Box::new(CpuRows::new(hemicubes));
    match drawing.backend {
        BackendChoice::Cpu => Ok(Backend::without_choice(cpu)),
        BackendChoice::Gpu => {
            let gpu = gpu(hemicubes, AdapterChoice::Any)?;
            if drawing.is_gpu_tried {
                as_asked(hemicubes, cpu, gpu)
            } else {
                Ok(Backend::without_choice(gpu))
            }
        }
        BackendChoice::Auto => Ok(match gpu(hemicubes, AdapterChoice::RealOnly) {
            Err(BackendError::NoAdapter) => Backend::without_choice(cpu),
            gpu => by_evidence(hemicubes, cpu, gpu),
        }),
    }
}

/// Opens a back end that has drawn rows before, in this run or an earlier one.
///
/// # Errors
/// An adapter that is missing, or that will not do.
pub fn open_again<'a>(
    hemicubes: &Arc<Hemicubes<'a>>,
    drawer: Drawer,
) -> Result<Backend<'a>, BackendError> {
    Ok(Backend::without_choice(match drawer {
        Drawer::Cpu => Box::new(CpuRows::new(hemicubes)),
        Drawer::Gpu => gpu(hemicubes, AdapterChoice::Any)?,
    }))
}

/// A GPU that was asked for.
fn as_asked<'a>(
    hemicubes: &Hemicubes,
    mut cpu: Box<dyn RowSource + 'a>,
    mut gpu: Box<dyn RowSource + 'a>,
) -> Result<Backend<'a>, BackendError> {
    let trial = Trial::of(hemicubes, &mut *cpu, &mut *gpu)?;
    let disagreement = trial.and_then(|trial| trial.disagreement());
    Ok(Backend {
        choice: Choice {
            remark: disagreement.map(|disagreement| {
                let name = name(&*gpu);
                format!("warning: {name} {disagreement}; use --backend cpu")
            }),
            trial,
        },
        source: gpu,
    })
}

/// The GPU where it draws the same rows and is faster, else the CPU.
fn by_evidence<'a>(
    hemicubes: &Hemicubes,
    mut cpu: Box<dyn RowSource + 'a>,
    gpu: Result<Box<dyn RowSource + 'a>, BackendError>,
) -> Backend<'a> {
    let tried = gpu.and_then(|mut gpu| {
        let trial = Trial::of(hemicubes, &mut *cpu, &mut *gpu)?;
        Ok((gpu, trial))
    });
    let on_cpu = |reason: String, trial| {
        let remark = Some(format!("the GPU is not used: {reason}"));
        (remark, trial)
    };
    let (remark, trial) = match tried {
        Err(error) => on_cpu(error.to_string(), None),
        // Without receivers nobody draws anything.
        Ok((_, None)) => (None, None),
        Ok((gpu, Some(trial))) => {
            let objection = trial.disagreement().or_else(|| trial.slowness());
            let Some(objection) = objection else {
                return Backend {
                    source: gpu,
                    choice: Choice {
                        remark: None,
                        trial: Some(trial),
                    },
                };
            };
            on_cpu(format!("{} {objection}", name(&*gpu)), Some(trial))
        }
    };
    Backend {
        source: cpu,
        choice: Choice { remark, trial },
    }
}

/// The adapter, without the word gpu in front.
fn name(gpu: &dyn RowSource) -> String {
    let told = gpu.describe();
    told.strip_prefix("gpu, ").unwrap_or(&told).to_owned()
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

/// Whether a GPU can be opened, a software one too.
///
/// # Errors
/// Why not.
#[cfg(feature = "gpu")]
pub fn probe_gpu() -> Result<(), BackendError> {
    crate::gpu::adapter::Gpu::open(AdapterChoice::Any).map(drop)
}

/// Without the gpu back end there is no adapter.
#[cfg(not(feature = "gpu"))]
pub fn probe_gpu() -> Result<(), BackendError> {
    Err(BackendError::NoAdapter)
}
