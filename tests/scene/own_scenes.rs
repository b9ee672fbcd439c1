//! Every scene of our own can be rendered.

use std::path::Path;

use photonfarm::import;
use photonfarm::scene::Scene;

#[test]
fn every_scene_of_the_folder_prepares_without_a_notice() {
    let folders = std::fs::read_dir("scenes").expect("scenes stands beside the manifest");
    let files: Vec<_> = folders
        .map(|entry| entry.expect("a readable folder").path().join("scene.xml"))
        .filter(|file| file.exists())
        .collect();
    assert!(files.len() >= 20, "only {} scenes were found", files.len());
    for file in files {
        let scene = prepare(&file);
        assert!(scene.notices.is_empty(), "{}: {:?}", file.display(), scene.notices);
        assert_eq!(scene.integrator.expect("an integrator").name, "sppm", "{}", file.display());
    }
}

fn prepare(file: &Path) -> Scene {
    let description = import::load_file(file, &[]).unwrap_or_else(|error| panic!("{error}"));
    Scene::prepare(&description).unwrap_or_else(|error| panic!("{error}"))
}
