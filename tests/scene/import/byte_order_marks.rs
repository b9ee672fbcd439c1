//! Text files may begin with a byte order mark of UTF-8, which some editors write.

use std::path::Path;

use photonfarm::import::load_file;
use photonfarm::scene::Scene;

/// A scene file and the files beside it. Each gets a mark.
const SCENES: &[(&str, &[(&str, &str)])] = &[
    (
        "scene.xml",
        &[
            (
                "scene.xml",
                "<scene version='3.0.0'><sensor type='perspective'><transform name='to_world'><translate z='-9'/></transform></sensor>
                <include filename='more.xml'/>
                <shape type='obj'><string name='filename' value='a.obj'/></shape>
                <shape type='ply'><string name='filename' value='a.ply'/></shape>
                <shape type='linearcurve'><string name='filename' value='a.txt'/></shape>
                <emitter type='ies'><string name='filename' value='a.ies'/></emitter></scene>",
            ),
            (
                "more.xml",
                "<scene version='3.0.0'><shape type='sphere'><bsdf type='diffuse'>
                <spectrum name='reflectance' filename='a.spd'/></bsdf></shape></scene>",
            ),
            ("a.spd", "400 0.2\n700 0.6\n"),
            ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
            (
                "a.ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            ),
            ("a.txt", "0 0 0 0.1\n0 0 1 0.1\n"),
            ("a.ies", "TILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 50\n0 90\n0\n100 10\n"),
        ],
    ),
    (
        "old.xml",
        &[
            (
                "old.xml",
                "<scene version='0.6.0'><sensor type='perspective'><transform name='toWorld'><translate z='-9'/></transform></sensor>
                <shape type='obj'><string name='filename' value='a.obj'/></shape>
                <shape type='sphere'><bsdf type='diffuse'><spectrum name='reflectance' filename='a.spd'/></bsdf></shape>
                <emitter type='point'/></scene>",
            ),
            ("a.spd", "400 0.2\n700 0.6\n"),
            ("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"),
            ("a.mtl", "newmtl red\nKd 0.9 0.1 0.1\n"),
        ],
    ),
    (
        "scene.pbrt",
        &[
            (
                "scene.pbrt",
                "LookAt 0 0 9  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\nInclude \"more.pbrt\"\nLightSource \"point\"\n",
            ),
            ("more.pbrt", "Material \"diffuse\" \"spectrum reflectance\" \"a.spd\"\nShape \"sphere\"\n"),
            ("a.spd", "400 0.2\n700 0.6\n"),
        ],
    ),
    (
        "scene.mgf",
        &[
            ("scene.mgf", "i more.mgf\nm glow =\ned 9\nv a =\np 0 0 3\nsph a .1\n"),
            ("more.mgf", "m red =\nc red =\ncxy .6 .3\nrd .5\nv a =\np 0 0 0\nsph a 1\n"),
        ],
    ),
    (
        "scene.json",
        &[(
            "scene.json",
            r#"{"type": "scene", "a": {"type": "perspective"}, "b": {"type": "sphere", "center": [0, 0, 9]}, "c": {"type": "point"}}"#,
        )],
    ),
];

fn outcome(folder: &Path, scene: &str, files: &[(&str, &str)], mark: &str) -> String {
    for (name, text) in files {
        std::fs::write(folder.join(name), format!("{mark}{text}")).expect("writes");
    }
    let description =
        load_file(&folder.join(scene), &[]).unwrap_or_else(|error| panic!("{scene} with {mark:?}: {error}"));
    let scene = Scene::prepare(&description).unwrap_or_else(|error| panic!("{scene} with {mark:?}: {error}"));
    let (count, bounds) = (scene.geometry.primitive_count(), scene.geometry.bounds());
    format!("{count} {bounds:?} {:?} {:?} {:?}", scene.materials, scene.lights.lights(), scene.notices)
}

#[test]
fn a_byte_order_mark_changes_nothing() {
    for (scene, files) in SCENES {
        let folder = tempfile::tempdir().expect("a folder");
        let [plain, marked] = ["", "\u{feff}"].map(|mark| outcome(folder.path(), scene, files, mark));
        assert_eq!(plain, marked, "{scene}");
    }
}
