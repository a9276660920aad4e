//! What each stage moves, and what share of the memory's bandwidth that is.

use crate::arguments::{Section, command_of};
use crate::stages::{Drawing, Gathering, Stages};
use crate::text::{count, figures, heading, percent, table};

/// What one thing of a stage takes: a pixel, or an entry.
struct Moved {
    stage: &'static str,
    of: &'static str,
    seconds: f64,
    bytes: f64,
    threads: usize,
}

impl Moved {
    fn cells(&self, scene: String, stages: &Stages) -> Vec<String> {
        let rate = self.bytes / self.seconds;
        vec![
            self.stage.to_owned(),
            scene,
            self.of.to_owned(),
            self.threads.to_string(),
            figures(self.bytes),
            figures(1e9 * self.seconds),
            figures(rate / 1e9),
            percent(rate / stages.bandwidth(self.threads)),
        ]
    }
}

fn drawing(drawing: &Drawing) -> [Moved; 3] {
    let per_pixel = |stage, seconds: f64, bytes: f64| Moved {
        stage,
        of: "pixel",
        seconds: seconds / drawing.pixels,
        bytes: bytes / drawing.pixels,
        threads: 1,
    };
    let (item_buffer, row) = (drawing.item_buffer.median, drawing.row.timing.median);
    // A patch ID a pixel.
    let ids = drawing.pixels * size_of::<u32>() as f64;
    [
        per_pixel("item buffer and look-up", item_buffer, ids),
        // Of two measurements, that may cross where merging takes next to nothing.
        per_pixel("merging", (row - item_buffer).max(1e-12), drawing.row.bytes),
        per_pixel("whole row", row, ids + drawing.row.bytes),
    ]
}

fn gathering(gathering: &Gathering) -> Moved {
    let iteration = gathering.iteration;
    Moved {
        stage: "iteration",
        of: "entry",
        seconds: iteration.seconds / iteration.entries as f64,
        bytes: iteration.bytes as f64 / iteration.entries as f64,
        threads: iteration.threads,
    }
}

/// The section.
pub fn section(stages: &Stages) -> String {
    let mut rows = Vec::new();
    for d in &stages.drawings {
        let scene = format!(
            "{}, {} patches, {} pixels",
            d.name,
            count(d.patches.into()),
            d.resolution
        );
        rows.extend(drawing(d).iter().map(|m| m.cells(scene.clone(), stages)));
    }
    for g in &stages.gatherings {
        let scene = format!("{}, {} patches", g.name, count(g.patches.into()));
        rows.push(gathering(g).cells(scene, stages));
    }
    let header = [
        "stage", "scene", "of one", "threads", "bytes", "ns", "GB/s", "share",
    ];
    format!(
        "{}Bytes that a stage hands on, patch IDs and entries of rows, or reads, kept entries, and the time for \
         them; the share is of the bandwidth that reading memory reaches on as many threads, from the section \
         before ({}). Merging is the difference of the whole row and the item buffer. A stage with a share near \
         100 % waits for memory; one far below waits for something else, which this table does not tell.\n\n{}",
        heading("What limits each stage"),
        command_of(Section::Limits),
        table(&header, 3, &rows)
    )
}
