//! What becomes of a GPU that draws the same, another one that does not, and a slow one.

use std::ops::Range;
use std::time::Duration;

use super::*;
use crate::rows::RowBatch;
use crate::settings::{FormFactorSettings, Points};

/// Stands in for a GPU: the CPU's rows, and what else is said.
struct Fake<'a> {
    cpu: CpuRows<'a>,
    /// What each batch waits for.
    wait: Duration,
    /// Whether half of what each row sees of its first source is lost.
    is_wrong: bool,
    /// Batches after which it is lost.
    lost_after: usize,
}

impl<'a> Fake<'a> {
    fn new(hemicubes: &Arc<Hemicubes<'a>>) -> Self {
        Self {
            cpu: CpuRows::new(hemicubes),
            wait: Duration::ZERO,
            is_wrong: false,
            lost_after: usize::MAX,
        }
    }
}

impl RowSource for Fake<'_> {
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError> {
        if self.lost_after == 0 {
            let what = "unplugged".to_owned();
            return Err(BackendError::DeviceLost { what });
        }
        self.lost_after -= 1;
        std::thread::sleep(self.wait);
        let mut drawn = self.cpu.draw_rows(receivers)?;
        for row in drawn.rows_mut() {
            if self.is_wrong {
                let lost = 0.5 * row.entries[0].units;
                row.entries[0].units -= lost;
                row.unseen.open += lost as u32;
            }
        }
        Ok(drawn)
    }

    fn preferred_batch(&self) -> u32 {
        64
    }

    fn backend(&self) -> &'static str {
        "gpu"
    }

    fn describe(&self) -> String {
        "gpu, Fake 3000".to_owned()
    }
}

/// Longer than any batch of rows takes on the slowest of machines.
const SLOW: Duration = Duration::from_millis(150);

/// Calls with the hemicubes of a room.
fn with_room(test: impl FnOnce(&Arc<Hemicubes>)) {
    let scene = test_scenes::furnished_room(0.5);
    let settings = FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(32)
    };
    test(&Arc::new(Hemicubes::new(&scene, settings)));
}

/// `cpu` or `gpu`, and how it was chosen between a CPU that waits as long and the fake.
fn chosen<'a>(
    hemicubes: &Arc<Hemicubes<'a>>,
    cpu_waits: Duration,
    gpu: Fake<'a>,
) -> (String, Choice) {
    let cpu = Fake {
        wait: cpu_waits,
        ..Fake::new(hemicubes)
    };
    let backend = by_evidence(hemicubes, Box::new(OnCpu(cpu)), Ok(Box::new(gpu)));
    (backend.source.backend().to_owned(), backend.choice)
}

/// A fake that stands in for the CPU.
struct OnCpu<'a>(Fake<'a>);

impl RowSource for OnCpu<'_> {
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError> {
        self.0.draw_rows(receivers)
    }

    fn preferred_batch(&self) -> u32 {
        self.0.preferred_batch()
    }

    fn describe(&self) -> String {
        "cpu".to_owned()
    }
}

#[test]
fn a_gpu_that_agrees_and_is_faster_is_taken_without_a_word() {
    with_room(|hemicubes| {
        let (name, choice) = chosen(hemicubes, SLOW, Fake::new(hemicubes));
        assert_eq!((name.as_str(), &choice.remark), ("gpu", &None));
        let trial = choice.trial.unwrap();
        assert!(trial.difference.to_bits() == 0.0_f64.to_bits(), "{trial:?}");
        assert!(
            trial.gpu_hemicubes_per_second > trial.cpu_hemicubes_per_second,
            "{trial:?}"
        );
        assert!(trial.hemicubes >= 4, "{trial:?}");
    });
}

#[test]
fn a_slower_gpu_is_not_taken_and_both_speeds_are_told() {
    with_room(|hemicubes| {
        let gpu = Fake {
            wait: SLOW,
            ..Fake::new(hemicubes)
        };
        let (name, choice) = chosen(hemicubes, Duration::ZERO, gpu);
        let trial = choice.trial.unwrap();
        assert_eq!(name, "cpu");
        assert_eq!(
            choice.remark.unwrap(),
            format!(
                "the GPU is not used: Fake 3000 is slower here, {:.0} against {:.0} hemicubes a second",
                trial.gpu_hemicubes_per_second, trial.cpu_hemicubes_per_second
            )
        );
    });
}

#[test]
fn a_gpu_that_draws_other_rows_is_not_taken_however_fast_it_is() {
    with_room(|hemicubes| {
        let gpu = Fake {
            is_wrong: true,
            ..Fake::new(hemicubes)
        };
        let (name, choice) = chosen(hemicubes, SLOW, gpu);
        let trial = choice.trial.unwrap();
        assert_eq!(name, "cpu");
        assert!(trial.difference > trial.bound, "{trial:?}");
        assert_eq!(
            choice.remark.unwrap(),
            format!(
                "the GPU is not used: Fake 3000 draws other rows than the CPU: {:.2} % of what a patch sees is \
                 elsewhere, more than {:.2} %",
                100.0 * trial.difference,
                100.0 * trial.bound
            )
        );
    });
}

#[test]
fn a_gpu_that_does_not_draw_is_not_taken() {
    with_room(|hemicubes| {
        let lost = "the GPU is not used: the GPU device was lost (unplugged)";
        for lost_after in [0, 3] {
            let gpu = Fake {
                lost_after,
                ..Fake::new(hemicubes)
            };
            let (name, choice) = chosen(hemicubes, Duration::ZERO, gpu);
            assert_eq!((name.as_str(), choice.trial), ("cpu", None));
            let remark = choice.remark.unwrap();
            assert!(remark.starts_with(lost), "{remark}");
        }
        let error = BackendError::Unsuitable {
            adapter: "Fake 3000".to_owned(),
            what: "it has no memory".to_owned(),
        };
        let cpu = Box::new(CpuRows::new(hemicubes));
        let backend = by_evidence(hemicubes, cpu, Err(error));
        assert_eq!(
            backend.choice.remark.unwrap(),
            "the GPU is not used: adapter \"Fake 3000\": it has no memory; use --backend cpu"
        );
        assert_eq!(backend.source.backend(), "cpu");
    });
}

#[test]
fn a_gpu_that_was_asked_for_draws_with_a_warning_where_its_rows_are_others() {
    with_room(|hemicubes| {
        let open = |is_wrong, wait| {
            let gpu = Fake {
                wait,
                is_wrong,
                ..Fake::new(hemicubes)
            };
            let cpu = Box::new(CpuRows::new(hemicubes));
            as_asked(hemicubes, cpu, Box::new(gpu)).unwrap()
        };
        // Slow, but nobody asked for a fast one.
        let backend = open(false, SLOW);
        assert_eq!(backend.source.backend(), "gpu");
        assert_eq!(backend.choice.remark, None);
        assert!(backend.choice.trial.is_some());

        let backend = open(true, Duration::ZERO);
        assert_eq!(backend.source.backend(), "gpu");
        let remark = backend.choice.remark.unwrap();
        let warning = "warning: Fake 3000 draws other rows than the CPU: ";
        assert!(remark.starts_with(warning), "{remark}");
        assert!(remark.ends_with("; use --backend cpu"), "{remark}");

        let gpu = Fake {
            lost_after: 1,
            ..Fake::new(hemicubes)
        };
        let cpu = Box::new(CpuRows::new(hemicubes));
        let lost = as_asked(hemicubes, cpu, Box::new(gpu)).err();
        assert!(
            matches!(lost, Some(BackendError::DeviceLost { .. })),
            "{lost:?}"
        );
    });
}

#[test]
fn what_is_no_number_is_no_agreement() {
    let trial = Trial {
        hemicubes: 48,
        cpu_hemicubes_per_second: f64::NAN,
        gpu_hemicubes_per_second: 1.0,
        difference: f64::NAN,
        bound: 0.001,
    };
    assert!(trial.disagreement().is_some() && trial.slowness().is_some());
}
