//! Names and shares of what pixels see first, where the scene says them.

use crate::scene_text::prepare;
use photonfarm::estimate::picture_files::{Matte, RANKS, name_id};
use photonfarm::render::mattes::mattes;
use photonfarm::scene::Scene;

/// A camera that looks along -z at the square from (-1, -1) to (1, 1), of one pixel.
fn scene(shapes: &str) -> Scene {
    let film = "<film type='hdrfilm'><integer name='width' value='1'/><integer name='height' value='1'/><rfilter type='box'/></film>";
    let place = "<transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>";
    let body = format!("<sensor type='orthographic'>{place}{film}</sensor><emitter type='constant'/>{shapes}");
    prepare(&body, &[]).expect("a good scene")
}

/// A rectangle that fills cells of the 4 × 4 into which the picture falls: columns `left..right` of a row.
fn cells(id: &str, [left, right, row]: [i32; 3], material: &str) -> String {
    let middle = |from: i32, to: i32| f64::from(from + to) / 4.0 - 1.0;
    let (x, y) = (middle(left, right), -middle(row, row + 1));
    let place = format!(
        "<transform name='to_world'><scale x='{}' y='0.25'/><translate x='{x}' y='{y}'/></transform>",
        f64::from(right - left) / 4.0
    );
    let id = if id.is_empty() { String::new() } else { format!(" id='{id}'") };
    format!("<shape type='rectangle'{id}>{place}{material}</shape>")
}

/// The names of a pixel with the rays that meet them.
fn shown(matte: &Matte) -> Vec<(&str, u8)> {
    matte.things.iter().zip(&matte.rays).map(|(thing, rays)| (matte.names[*thing as usize].as_str(), *rays)).collect()
}

#[test]
fn analytic_more_objects_than_ranks_leave_the_largest() {
    let places: [(&str, [i32; 3]); 8] = [
        ("one a", [0, 1, 0]),
        ("three", [1, 4, 0]),
        ("four", [0, 4, 1]),
        ("one b", [0, 1, 2]),
        ("one c", [1, 2, 2]),
        ("two", [2, 4, 2]),
        ("one d", [0, 1, 3]),
        ("one e", [1, 2, 3]),
    ];
    let shapes: String = places.map(|(id, place)| cells(id, place, "")).concat();
    let mattes = mattes(&scene(&shapes));
    let expected = [("four", 4), ("three", 3), ("two", 2), ("one a", 1), ("one b", 1), ("one c", 1)];
    assert_eq!(shown(&mattes.objects), expected, "of as many rays, the first of the scene");
    assert_eq!(expected.len(), RANKS);
    assert_eq!(mattes.objects.names.len(), 8, "what has no rank has a name");
    assert_eq!(shown(&mattes.materials), [("default material", 14)], "two cells show nothing");
    let channels = mattes.objects.channels();
    assert_eq!((channels[0][0], channels[1][0]), (name_id("four"), 0.25));
    assert_eq!((channels[10][0], channels[11][0]), (name_id("one c"), 1.0 / 16.0));
}

#[test]
fn analytic_things_of_one_name_count_together() {
    let group = "<shape type='shapegroup' id='leaf'><shape type='rectangle' id='blade'><bsdf type='diffuse' id='green'/></shape></shape>";
    let instance = |id: &str, x: f64, y: f64| {
        let place =
            format!("<transform name='to_world'><scale x='0.5' y='0.5'/><translate x='{x}' y='{y}'/></transform>");
        format!("<shape type='instance'{id}>{place}<ref id='leaf'/></shape>")
    };
    // Three quarters of the picture; the fourth holds shapes without names, two of one material.
    let leaves = [instance("", -0.5, 0.5), instance("", 0.5, 0.5), instance(" id='last leaf'", -0.5, -0.5)].concat();
    let grey = "<ref id='grey'/>";
    let shapes =
        [cells("", [2, 3, 2], grey), cells("", [3, 4, 2], grey), cells("shape 1", [2, 4, 3], "<bsdf type='diffuse'/>")];
    let scene = scene(&format!("<bsdf type='diffuse' id='grey'/>{group}{leaves}{}", shapes.concat()));
    let mattes = mattes(&scene);
    let objects = [("leaf", 8), ("last leaf", 4), ("shape 1", 2), ("shape 4", 1), ("shape 5", 1)];
    assert_eq!(shown(&mattes.objects), objects);
    assert_eq!(shown(&mattes.materials), [("green", 12), ("grey", 2), ("material 3", 2)]);
}

#[test]
fn analytic_made_up_names_are_not_those_of_others() {
    let shapes = [cells("", [0, 4, 0], ""), cells("shape 1", [0, 4, 1], ""), cells("", [0, 4, 2], "")].concat();
    let mattes = mattes(&scene(&shapes));
    assert_eq!(mattes.objects.names, ["shape 1_", "shape 1", "shape 3"]);
}

#[test]
fn analytic_mattes_have_the_same_bits_on_any_number_of_threads() {
    let scene = scene(&cells("a", [0, 3, 1], ""));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| mattes(&scene))
    };
    assert_eq!(on(1), on(2));
}
