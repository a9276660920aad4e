//! The one place where form factors are put together.
//!
//! Runs, `verify`, the demo, benchmarks and tests all get their rows from here, so that what is verified is what users
//! get. It decides, from the scene and the settings alone:
//!
//! | what | how |
//! |---|---|
//! | levels | sources are patches, or coarser where the scene is large ([`crate::two_levels`]) |
//! | closed forms | rows are formulas where nothing hides anything and that costs less ([`crate::convex`]) |
//! | back end | who draws hemicubes else ([`crate::backend`]) |
//! | lamps | which emitters have views of their own ([`crate::lamps`]) |
//! | unlit patches | whose rows nobody needs ([`crate::unlit`]) |
//! | cache | which rows are kept ([`crate::row_cache`]) |
//! | files | which rows were drawn by an earlier run ([`crate::row_file`]) |

use std::sync::Arc;

use scene::{PatchId, Scene, Solution};
use visibility::hemicube::MAX_RESOLUTION;

use crate::backend::{self, Backend, Drawer, RowOrigin};
use crate::cancel::CancelToken;
use crate::convex::ConvexRows;
use crate::hemicubes::Hemicubes;
use crate::lamps::with_lamps;
use crate::receivers::{Closer, Patches, Receivers};
use crate::row_cache::RowCache;
use crate::row_file::{Identity, RowFiles, StoredRows};
use crate::rows::{BackendError, RowSource};
use crate::settings::{
    BackendChoice, ClosedForms, Drawing, FormFactorSettings, MOST_ON_ONE_LEVEL, SolutionSettings,
    SourceArea, Target,
};
use crate::sources::Sources;
use crate::two_levels;
use crate::unlit;

/// Sources from which a function is gathered are at most this share of the scene's area, times the error that is asked of it, within
/// these bounds: what they bring falls with their size.
const FUNCTION_SOURCE: f64 = 0.05;
const FUNCTION_SOURCES: [f64; 2] = [1.0 / 65536.0, 1.0 / 512.0];

/// By how many times as many points patches are looked at more closely, at least.
const CLOSER_POINTS: u32 = 4;

/// The largest area, m^2, of sources from which a function is gathered.
pub fn area_of_function_sources(scene: &Scene, target: Target) -> f64 {
    let [least, most] = FUNCTION_SOURCES;
    let share = (FUNCTION_SOURCE * target.strictest()).clamp(least, most);
    share * scene.area()
}

/// The form factors of a scene, drawn as they are asked for.
#[derive(Clone, Debug)]
pub struct FormFactors<'a> {
    scene: &'a Scene,
    settings: FormFactorSettings,
    drawing: Drawing,
    /// Where the rows have come from so far; `None`: no row has.
    origin: Option<RowOrigin>,
    /// What a user should know of that.
    remark: Option<String>,
    cancel: CancelToken,
    row_files: Option<RowFiles>,
}

/// How patches are looked at more closely.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closely {
    /// At the same points.
    Pixels,
    /// At several times as many points, too.
    PointsAndPixels,
}

/// Among what a scene is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Levels {
    /// Its patches.
    Patches,
    /// Sources of at most this area, m^2, from which the patches then gather.
    Sources(f64),
    /// Finer and finer sources, until the error that they bring is small.
    Automatic,
}

/// Whose rows are needed.
#[derive(Clone, Copy, Debug)]
pub enum Needed<'s> {
    /// All.
    All,
    /// Those of patches that light can reach, in a solution that goes on from this one.
    Lit(&'s Solution),
}

impl<'a> FormFactors<'a> {
    /// The form factors of a scene. Nothing is drawn yet.
    pub fn new(scene: &'a Scene, settings: FormFactorSettings, drawing: Drawing) -> Self {
        Self {
            scene,
            settings,
            drawing,
            origin: None,
            remark: None,
            cancel: CancelToken::new(),
            row_files: None,
        }
    }

    /// The same, for a solution that goes on from `start`, by these settings: where nothing else is asked for, its rows
    /// come from where those of the start came from, so that it goes on with the same bits. A start that was solved with
    /// other settings gives its irradiances alone, and decides nothing here.
    #[must_use]
    pub fn going_on(self, start: Option<&Solution>, settings: SolutionSettings) -> Self {
        let before = start.and_then(|start| start.provenance.settings.as_ref());
        let recorded = before.and_then(|before| Some((before, RowOrigin::recorded_in(before)?)));
        let Some((before, origin)) = recorded else {
            return self;
        };
        let mut now = settings.recorded(self.scene.patch_count());
        origin.record_in(&mut now);
        if *before == now {
            self.drawn_where(origin)
        } else {
            self
        }
    }

    /// The same, for who only looks at a solution: where nothing else is asked for, who has drawn its rows draws these.
    #[must_use]
    pub fn drawn_as(self, solution: &Solution) -> Self {
        let recorded = solution.provenance.settings.as_ref();
        match recorded.and_then(RowOrigin::recorded_in) {
            Some(origin) => self.drawn_where(origin),
            None => self,
        }
    }

    /// The same, whose rows come from there where nothing else is asked for, and from the CPU if its GPU is missing.
    fn drawn_where(self, mut origin: RowOrigin) -> Self {
        if self.drawing.backend != BackendChoice::Auto {
            return self;
        }
        let mut remark = None;
        if origin.drawer == Some(Drawer::Gpu)
            && let Err(error) = backend::probe_gpu()
        {
            origin.drawer = Some(Drawer::Cpu);
            remark = Some(format!(
                "the GPU that the solution is from is not used: {error}"
            ));
        }
        Self {
            origin: Some(origin),
            remark,
            ..self
        }
    }

    /// The same, after these rows were opened: others come from the same back end.
    #[must_use]
    pub fn after(self, rows: &RowCache) -> Self {
        let before = self.origin.unwrap_or_default();
        Self {
            origin: Some(before.and(rows.origin())),
            ..self
        }
    }

    /// Where the rows come from, as far as that is decided.
    pub fn origin(&self) -> Option<RowOrigin> {
        let asked_for = RowOrigin::asked_for(self.drawing.backend);
        self.origin.or(asked_for)
    }

    /// The same of another scene.
    #[must_use]
    pub fn of_scene<'s>(&self, scene: &'s Scene) -> FormFactors<'s> {
        FormFactors {
            scene,
            settings: self.settings,
            drawing: self.drawing,
            origin: self.origin,
            remark: self.remark.clone(),
            cancel: self.cancel.clone(),
            row_files: self.row_files.clone(),
        }
    }

    /// The same by other settings.
    #[must_use]
    pub fn with_settings(self, settings: FormFactorSettings) -> Self {
        Self { settings, ..self }
    }

    /// The same, whose drawing of many rows ends early where the token says so.
    #[must_use]
    pub fn with_cancel(self, cancel: &CancelToken) -> Self {
        Self {
            cancel: cancel.clone(),
            ..self
        }
    }

    /// The same, whose rows are looked for and kept in these files, if any.
    #[must_use]
    pub fn with_row_files(self, row_files: Option<RowFiles>) -> Self {
        Self { row_files, ..self }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// What decides them.
    pub fn settings(&self) -> FormFactorSettings {
        self.settings
    }

    /// What kept rows may take, bytes.
    pub fn memory_bytes(&self) -> u64 {
        self.drawing.memory_bytes
    }

    /// Among what the scene is solved, where sources are to be so coarse.
    pub fn levels(&self, source_area: SourceArea) -> Levels {
        match source_area {
            SourceArea::AtMost(area) => {
                // No source is larger than all, and a file holds no infinity.
                let area = area.min(self.scene.area());
                let count = two_levels::sources(self.scene, area).patch_count();
                if count < self.scene.patch_count() {
                    Levels::Sources(area)
                } else {
                    Levels::Patches
                }
            }
            SourceArea::Auto if self.scene.patch_count() > MOST_ON_ONE_LEVEL => Levels::Automatic,
            SourceArea::Auto | SourceArea::Patches => Levels::Patches,
        }
    }

    /// Among what the scene is solved where a function is gathered in the end, see [`crate::function`].
    pub fn levels_of_function(&self, source_area: SourceArea, target: Target) -> Levels {
        if source_area != SourceArea::Auto {
            return self.levels(source_area);
        }
        let area = area_of_function_sources(self.scene, target);
        let count = two_levels::sources(self.scene, area).patch_count();
        if count <= self.scene.patch_count() / 2 {
            Levels::Sources(area)
        } else {
            Levels::Patches
        }
    }

    /// The rows of the scene's patches to its patches.
    ///
    /// # Errors
    /// A back end that does not open.
    pub fn rows(&self, needed: Needed) -> Result<RowCache<'a>, BackendError> {
        self.rows_to(Sources::patches_of(self.scene), needed)
    }

    /// The rows of the patches over which the sources are. Rows to coarser sources are gathered with once and are not
    /// worth keeping, neither in memory nor in a file; formulas are not worth a file.
    ///
    /// # Errors
    /// As [`Self::rows`].
    pub fn rows_to(
        &self,
        sources: Sources<'a>,
        needed: Needed,
    ) -> Result<RowCache<'a>, BackendError> {
        let memory_bytes = if sources.are_patches() {
            self.drawing.memory_bytes
        } else {
            0
        };
        let hemicubes = Arc::new(Hemicubes::of_patches(sources, self.settings));
        let unlit = match needed {
            Needed::All => None,
            Needed::Lit(start) => unlit::unlit(&hemicubes, start),
        };
        let Backend { source, choice } = match self.formulas(&hemicubes) {
            Some(rows) => Backend::without_choice(Box::new(rows)),
            None => self.open(&hemicubes)?,
        };
        let sources = hemicubes.sources();
        let is_stored = sources.are_patches() && source.draws_hemicubes();
        let files = self.row_files.as_ref().filter(|_| is_stored);
        let stored = files.map(|files| {
            let (patches, seen) = (sources.patches(), sources.scene());
            let identity = Identity::new(patches, seen, &self.settings, &source.identity());
            StoredRows::find(files, identity)
        });
        let mut rows = RowCache::new(&hemicubes, source, memory_bytes)
            .with_cancel(&self.cancel)
            .with_stored(stored)
            .with_choice(choice);
        if let Some(unlit) = unlit {
            rows.leave_out(unlit);
        }
        Ok(rows)
    }

    /// The rows of any receivers to some sources. They are drawn: formulas hold for points on the walls of a convex room,
    /// in front of which all of it lies, not for others.
    ///
    /// # Errors
    /// As [`Self::rows`].
    pub fn at(
        &self,
        receivers: Box<dyn Receivers + 'a>,
        sources: Sources<'a>,
    ) -> Result<Backend<'a>, BackendError> {
        self.open(&Arc::new(Hemicubes::at(receivers, sources, self.settings)))
    }

    /// The rows of some patches, more closely: by hemicubes of twice the resolution, turned otherwise. What the usual rows are off by
    /// shows in the difference.
    ///
    /// # Errors
    /// As [`Self::rows`].
    pub fn closer(
        &self,
        chosen: Vec<PatchId>,
        closely: Closely,
    ) -> Result<Backend<'a>, BackendError> {
        let FormFactorSettings {
            resolution,
            points,
            seed,
            ..
        } = self.settings;
        let sources = Sources::patches_of(self.scene);
        let patches = Patches::new(self.scene, sources.drawable(), points, seed);
        let closer = Self {
            settings: FormFactorSettings {
                resolution: (2 * resolution).min(MAX_RESOLUTION),
                ..self.settings
            },
            ..self.clone()
        };
        let times = match closely {
            Closely::Pixels => 1,
            Closely::PointsAndPixels => CLOSER_POINTS,
        };
        closer.at(Box::new(Closer::new(patches, chosen, times)), sources)
    }

    /// The rows of patches as formulas, where they can be had and are wanted.
    fn formulas(&self, hemicubes: &Arc<Hemicubes<'a>>) -> Option<ConvexRows<'a>> {
        let is_wanted = self.settings.closed_forms == ClosedForms::Auto
            && self.drawing.backend == BackendChoice::Auto
            && self.origin.is_none_or(|origin| origin.has_formulas);
        is_wanted.then(|| ConvexRows::new(hemicubes)).flatten()
    }

    /// Who draws the rows of hemicubes.
    fn open(&self, hemicubes: &Arc<Hemicubes<'a>>) -> Result<Backend<'a>, BackendError> {
        let Backend { source, mut choice } = match self.origin.and_then(|origin| origin.drawer) {
            Some(drawer) => backend::open_again(hemicubes, drawer)?,
            None => backend::open(hemicubes, self.drawing)?,
        };
        choice.remark = self.remark.clone().or(choice.remark);
        let source: Box<dyn RowSource + 'a> = with_lamps(hemicubes, self.settings.lamps, source);
        Ok(Backend { source, choice })
    }
}
