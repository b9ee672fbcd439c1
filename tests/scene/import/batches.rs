//! `batch`: sensors side by side in one film become cameras to choose from.

use photonfarm::import::changes::{Changes, with_changes};
use photonfarm::import::load_bytes;
use photonfarm::scene::Scene;

fn scene(film: &str, camera: Option<&str>) -> Result<Scene, String> {
    let text = format!(
        "<scene version='3.0.0'><sensor type='batch'>
        <sensor type='perspective' id='front'><transform name='to_world'><translate z='-6'/></transform>
            <film type='hdrfilm'><integer name='width' value='33'/></film></sensor>
        <sensor type='orthographic' id='side'><transform name='to_world'><translate x='3' z='-6'/></transform></sensor>
        <film type='hdrfilm'>{film}</film></sensor>
        <shape type='sphere'/><emitter type='constant'/></scene>"
    );
    let changes = Changes { camera: camera.map(str::to_owned), ..Changes::default() };
    let packed = with_changes(text.as_bytes(), &changes).map_err(|error| error.to_string())?;
    let description = load_bytes("a.xml", &packed, &[]).map_err(|error| error.to_string())?;
    Scene::prepare(&description).map_err(|error| error.to_string())
}

/// As Mitsuba 3.9.1 does: their own films do not count.
#[test]
fn each_sensor_of_a_batch_has_its_part_of_the_film() {
    let film = "<integer name='width' value='20'/><integer name='height' value='7'/>";
    for (camera, x) in [(None, 0.0), (Some("front"), 0.0), (Some("1"), 3.0), (Some("side"), 3.0)] {
        let scene = scene(film, camera).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((scene.width, scene.height), (10, 7), "{camera:?}");
        assert_eq!(scene.camera.position().x, x, "{camera:?}");
        assert!(scene.notices.iter().any(|notice| notice.contains("sensor \"batch\"")), "{:?}", scene.notices);
    }
    let plain = scene("", None).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((plain.width, plain.height), (384, 576));
}

#[test]
fn batches_that_cannot_be() {
    for (film, camera, expected) in [
        (
            "<integer name='width' value='9'/>",
            None,
            "a film 9 pixels wide cannot be divided among 2 sensors; give a width that 2 divides",
        ),
        ("<integer name='crop_width' value='9'/>", None, "the film of a batch is cropped"),
        ("", Some("back"), "there is no camera \"back\"; there are 0 \"front\", 1 \"side\""),
    ] {
        let found = scene(film, camera).err().unwrap_or_else(|| panic!("{film} is no error"));
        assert!(found.contains(expected), "{found}");
    }
}
