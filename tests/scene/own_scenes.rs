//! Every scene of our own can be rendered.

use std::path::{Path, PathBuf};

use photonfarm::import;
use photonfarm::method::{MethodChoice, SceneTraits, check, notices};
use photonfarm::scene::Scene;
use photonfarm::scene::description::{Child, PluginClass, SceneDescription};

use serde_json::json;

use crate::description_tree::tree;

/// Scenes that stand beside a `scene.xml`.
const VARIANTS: [&str; 7] = [
    "conference/spheres.xml",
    "house-of-lamps/alone.xml",
    "many-rooms/100-alone.xml",
    "many-rooms/100.xml",
    "many-rooms/alone.xml",
    "sealed-lamp/alone.xml",
    "thin-sheet/alone.xml",
];

/// A scene with lamps whose light does not reach its picture.
struct Sealed {
    scene: &'static str,
    /// The same without those lamps.
    alone: &'static str,
    lamps: usize,
}

const SEALED: [Sealed; 5] = [
    Sealed { scene: "sealed-lamp/scene.xml", alone: "sealed-lamp/alone.xml", lamps: 1 },
    Sealed { scene: "thin-sheet/scene.xml", alone: "thin-sheet/alone.xml", lamps: 1 },
    Sealed { scene: "many-rooms/scene.xml", alone: "many-rooms/alone.xml", lamps: 24 },
    Sealed { scene: "many-rooms/100.xml", alone: "many-rooms/100-alone.xml", lamps: 99 },
    Sealed { scene: "house-of-lamps/scene.xml", alone: "house-of-lamps/alone.xml", lamps: 40 },
];

#[test]
fn every_scene_of_the_folder_prepares_without_a_notice() {
    let folders = std::fs::read_dir("scenes").expect("scenes stands beside the manifest");
    let mut files: Vec<_> = folders
        .map(|entry| entry.expect("a readable folder").path().join("scene.xml"))
        .filter(|file| file.exists())
        .collect();
    assert!(files.len() >= 25, "only {} scenes were found", files.len());
    files.extend(VARIANTS.map(own_scene));
    for file in files {
        let scene = Scene::prepare(&load(&file)).unwrap_or_else(|error| panic!("{error}"));
        // One picture of a scene that moves shows one moment and one camera of it.
        let told = if file.ends_with("moving-lamp/scene.xml") { 2 } else { 0 };
        assert_eq!(scene.notices.len(), told, "{}: {:?}", file.display(), scene.notices);
        assert_eq!(scene.integrator.expect("an integrator").name, "sppm", "{}", file.display());
    }
}

#[test]
fn lamps_sealed_in_glass_are_told_where_lights_are_sampled() {
    let told = |scene: &str, method: &str, parameters: serde_json::Value| {
        let scene = Scene::prepare(&load(&own_scene(scene))).unwrap_or_else(|error| panic!("{error}"));
        let parameters = parameters.as_object().expect("an object").clone();
        let choice = MethodChoice { name: method.to_owned(), parameters };
        let method = check(&choice, scene.pixel_count() as u64).expect("good parameters");
        notices(&method, SceneTraits::of(&scene)).iter().any(|notice| notice.contains("meets mirrors or glass first"))
    };
    for scene in ["lamp-in-glass/scene.xml", "bathroom/scene.xml"] {
        assert!(told(scene, "sppm", json!({})), "{scene}");
        assert!(told(scene, "photon_map", json!({})), "{scene}");
        assert!(!told(scene, "sppm", json!({ "direct": "photons" })), "{scene}");
        assert!(!told(scene, "vcm", json!({})), "{scene}");
    }
    // Glass under a lamp seals nothing.
    for scene in ["cornell-diffuse/scene.xml", "cornell-glass-mirror/scene.xml", "still-life/scene.xml"] {
        assert!(!told(scene, "sppm", json!({})), "{scene}");
    }
}

#[test]
fn a_scene_alone_lacks_the_sealed_lamps_and_nothing_else() {
    for Sealed { scene, alone, lamps } in SEALED {
        let (mut description, alone) = (load(&own_scene(scene)), load(&own_scene(alone)));
        let more = description.root.children.split_off(alone.root.children.len());
        assert_eq!(tree(&description), tree(&alone), "{scene}");
        assert_eq!(more.len(), lamps, "{scene}");
        assert!(more.iter().all(is_lamp), "{scene}");
    }
}

fn is_lamp(child: &Child) -> bool {
    let emits = |part: &Child| part.node.class == PluginClass::Emitter;
    child.node.class == PluginClass::Shape && child.node.children.iter().any(emits)
}

fn own_scene(name: &str) -> PathBuf {
    Path::new("scenes").join(name)
}

fn load(file: &Path) -> SceneDescription {
    import::load_file(file, &[]).unwrap_or_else(|error| panic!("{error}"))
}
