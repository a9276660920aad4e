//! Models of unusual shapes and places, whose areas and view factors are known: a star of 600 corners, an attic as flat as a
//! sheet of paper, plates that almost touch, and a room where maps have it.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use tempfile::TempDir;
use tests::{Table, folder, output, run};

/// Wavefront text of polygons, each an object with a name.
fn obj(polygons: &[(&str, Vec<[f64; 3]>)]) -> String {
    let (mut text, mut vertices) = (String::new(), 0);
    for (name, corners) in polygons {
        writeln!(text, "o {name}").unwrap();
        for [x, y, z] in corners {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
        let indices = (1..=corners.len()).map(|k| (vertices + k).to_string());
        writeln!(text, "f {}", indices.collect::<Vec<_>>().join(" ")).unwrap();
        vertices += corners.len();
    }
    text
}

/// View factors between the objects of a model, with patches of at most so many m^2 and so many points each, at 64 pixels.
struct ViewFactors {
    folder: TempDir,
    table: Table,
}

impl ViewFactors {
    fn new(polygons: &[(&str, Vec<[f64; 3]>)], max_area: &str, points: &str) -> Self {
        let folder = folder();
        std::fs::write(folder.path().join("a.obj"), obj(polygons)).unwrap();
        run(&folder, "genx", &["a.rad", "a.obj", "--max-area", max_area]);
        let compute = "a.rad b.rad 64 --backend cpu --iterations 0 --view-factors f.csv --points";
        let compute: Vec<&str> = compute.split(' ').chain([points]).collect();
        run(&folder, "compute", &compute);
        let table = Table::read(&folder.path().join("f.csv"));
        Self { folder, table }
    }

    fn row(&self, from: &str, to: &str) -> usize {
        let is_it =
            |&k: &usize| self.table.text(k, "from") == from && self.table.text(k, "to") == to;
        (0..self.table.len()).find(is_it).unwrap()
    }

    fn between(&self, from: &str, to: &str) -> f64 {
        self.table.number(self.row(from, to), "view_factor")
    }

    fn row_sum(&self, from: &str) -> f64 {
        let from = (0..self.table.len()).find(|&k| self.table.text(k, "from") == from);
        self.table.number(from.unwrap(), "row_sum_from")
    }
}

/// A prism over a star whose 300 grooves are 1 cm wide and half a metre deep. Each of its 600 triangles about the middle
/// has two sides of 1 and 0.5 m and an angle of TAU / 600 between them.
#[test]
fn a_star_of_600_corners_is_closed() {
    let corner = |k: usize, z: f64| {
        let radius = if k.is_multiple_of(2) { 0.5 } else { 1.0 };
        let (sin, cos) = (TAU * k as f64 / 600.0).sin_cos();
        [radius * cos, radius * sin, z]
    };
    let floor: Vec<[f64; 3]> = (0..600).map(|k| corner(k, 0.0)).collect();
    let roof = (0..600).rev().map(|k| corner(k, 1.0)).collect();
    let mut polygons = vec![("floor", floor), ("roof", roof)];
    for k in 0..600 {
        let next = (k + 1) % 600;
        let side = [
            corner(next, 0.0),
            corner(k, 0.0),
            corner(k, 1.0),
            corner(next, 1.0),
        ];
        polygons.push(("sides", side.to_vec()));
    }
    let factors = ViewFactors::new(&polygons, "inf", "centroid");
    let area = factors
        .table
        .number(factors.row("floor", "roof"), "area_from");
    let expected = 600.0 * 0.5 * 0.5 * (TAU / 600.0).sin();
    // Corners are f32: 2^-24 of a metre along sides of half a metre each.
    assert!((area - expected).abs() < 1e-5, "{area}, {expected}");
    for object in ["floor", "roof", "sides"] {
        let sum = factors.row_sum(object);
        assert!((sum - 1.0).abs() < 1e-6, "{object}: {sum}");
    }
}

/// 10 x 1000 m, 0.3 m high. Seen across its length it is a triangle, whose sides' view factors are their lengths': from one roof
/// to the other (a + b - c) / (2 a) (Hottel's crossed strings), less than a thousandth of which gets lost at the gables.
#[test]
fn a_flat_attic_sees_itself_as_strings_say() {
    let [west, ridge, east] = [[0.0, 0.0], [5.0, 0.3], [10.0, 0.0]];
    let strip = |[ax, az]: [f64; 2], [bx, bz]: [f64; 2]| {
        let length = 1000.0;
        vec![
            [ax, 0.0, az],
            [bx, 0.0, bz],
            [bx, length, bz],
            [ax, length, az],
        ]
    };
    let gable = |y: f64| [west, ridge, east].map(|[x, z]| [x, y, z]).to_vec();
    let mut far = gable(1000.0);
    far.reverse();
    let polygons = [
        ("floor", strip(west, east)),
        ("west", strip(ridge, west)),
        ("east", strip(east, ridge)),
        ("gables", gable(0.0)),
        ("gables", far),
    ];
    let factors = ViewFactors::new(&polygons, "100", "auto");
    let roof = 5.0_f64.hypot(0.3);
    let expected = (2.0 * roof - 10.0) / (2.0 * roof);
    let found = factors.between("west", "east");
    // It is all at the horizon, where 64 pixels leave 2 % of it.
    assert!((found / expected - 1.0).abs() < 0.02, "{found}, {expected}");
    let floor = factors.between("west", "floor");
    assert!((floor - (1.0 - expected)).abs() < 1e-4, "{floor}");
}

/// The view factor between unit squares face to face at a distance (Howell, A catalog of radiation heat transfer
/// configuration factors, C-11).
fn facing_squares(distance: f64) -> f64 {
    let x = 1.0 / distance;
    let s = (1.0 + x * x).sqrt();
    let log = ((1.0 + x * x).powi(2) / (1.0 + 2.0 * x * x)).ln() / 2.0;
    2.0 / (PI * x * x) * (log + 2.0 * x * s * (x / s).atan() - 2.0 * x * x.atan())
}

/// What leaves between the plates does so within a gap's width of the rim, a fraction of a patch: points tell it to a few
/// percent of the patches that have a rim, a tenth of all, whatever the pixels.
#[test]
fn plates_that_almost_touch_see_little_but_each_other() {
    for gap in [1e-2, 1e-3] {
        let square = |z: f64| vec![[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        let mut high = square(gap);
        high.reverse();
        let factors = ViewFactors::new(&[("low", square(0.0)), ("high", high)], "0.001", "auto");
        let expected = facing_squares(gap);
        let found = factors.between("low", "high");
        assert!((found - expected).abs() < 1e-3, "{found}, {expected}");
    }
}

/// A room of 4 x 4 x 3 m, thousands of kilometres from zero: coordinates in f32 would have steps of half a metre there.
#[test]
fn a_room_in_map_coordinates_is_a_room_and_what_lies_at_zero_is_named() {
    let at = |x: f64, y: f64, z: f64| [512_345.678 + x, 5_412_345.678 + y, 412.34 + z];
    let (w, h) = (4.0, 3.0);
    let quad = |corners: [[f64; 3]; 4]| corners.map(|[x, y, z]| at(x, y, z)).to_vec();
    let o = 0.0;
    let mut polygons = vec![
        ("floor", quad([[o, o, o], [w, o, o], [w, w, o], [o, w, o]])),
        (
            "ceiling",
            quad([[o, o, h], [o, w, h], [w, w, h], [w, o, h]]),
        ),
        ("west", quad([[o, o, o], [o, w, o], [o, w, h], [o, o, h]])),
        ("east", quad([[w, o, o], [w, o, h], [w, w, h], [w, w, o]])),
        ("south", quad([[o, o, o], [o, o, h], [w, o, h], [w, o, o]])),
        ("north", quad([[o, w, o], [w, w, o], [w, w, h], [o, w, h]])),
    ];
    let factors = ViewFactors::new(&polygons, "0.1", "auto");
    // Howell's C-14, rectangles with a common edge at a right angle: h = 3/4, w = 1.
    for wall in ["west", "east", "south", "north"] {
        let found = factors.between("floor", wall);
        assert!((found / 0.179_32 - 1.0).abs() < 0.01, "{wall}: {found}");
    }
    polygons.push(("stray", vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
    let folder = &factors.folder;
    std::fs::write(folder.path().join("b.obj"), obj(&polygons)).unwrap();
    let refused = output(folder, "genx", &["stray.rad", "b.obj"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(said.contains("object \"stray\" lies 54"), "{said}");
    assert!(!folder.path().join("stray.rad").exists());
}
