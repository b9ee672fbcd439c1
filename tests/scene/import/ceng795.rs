//! Scenes of METU's CENG 795 come out as the cameras, lights, materials and shapes that they mean.

use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::chi_square::numbers;
use photonfarm::import::{load_bytes, load_file, pack};
use photonfarm::math::Vec2;
use photonfarm::scene::Scene;
use photonfarm::scene::description::{Node, PluginClass, SceneDescription, Value};

const CAMERA: &str = "<Position>0 -5 0</Position><Gaze>0 1 0</Gaze><Up>0 0 1</Up><FovY>90</FovY>
    <NearDistance>1</NearDistance><ImageResolution>60 40</ImageResolution><ImageName>a.exr</ImageName>";
const LIGHTS: &str =
    "<Lights><PointLight id='1'><Position>0 -3 2</Position><Intensity>9 8 7</Intensity></PointLight></Lights>";
const MATERIALS: &str = "<BRDFs><ModifiedPhong id='1' normalized='true'><Exponent>98</Exponent></ModifiedPhong></BRDFs>
    <Materials><Material id='1' BRDF='1'><DiffuseReflectance>.5 .4 .3</DiffuseReflectance></Material></Materials>";
const VERTICES: &str = "<VertexData>-1 0 -1\n1 0 -1 <!-- right -->\n1 0 1\n-1 0 1\n0 0 0\n</VertexData>";
const MESH: &str = "<Mesh id='1'><Material>1</Material><Faces>1 2 3\n3 4 1</Faces></Mesh>";

/// A scene of the usual parts, with some of them replaced.
struct Parts<'a> {
    depth: u32,
    camera: &'a str,
    attributes: &'a str,
    lights: &'a str,
    materials: &'a str,
    transformations: &'a str,
    objects: &'a str,
}

impl Default for Parts<'_> {
    fn default() -> Self {
        Self {
            depth: 3,
            camera: CAMERA,
            attributes: "",
            lights: LIGHTS,
            materials: MATERIALS,
            transformations: "",
            objects: MESH,
        }
    }
}

impl Parts<'_> {
    fn text(&self) -> String {
        let Self { depth, camera, attributes, lights, materials, transformations, objects } = self;
        format!(
            "<Scene>\n<MaxRecursionDepth>{depth}</MaxRecursionDepth>\n<Cameras><Camera id='1' {attributes}>{camera}</Camera>\
             </Cameras>\n{lights}\n{materials}\n<Transformations>{transformations}</Transformations>\n{VERTICES}\n\
             <Objects>{objects}</Objects>\n</Scene>\n"
        )
    }

    fn load(&self) -> SceneDescription {
        load_bytes("scene.xml", self.text().as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"))
    }
}

fn of_class(scene: &SceneDescription, class: PluginClass) -> Vec<&Node> {
    scene.root.children.iter().map(|child| &*child.node).filter(|node| node.class == class).collect()
}

/// A plugin in one line: numbers rounded, without places.
fn outline(node: &Node) -> String {
    let rounded = |numbers: &[f64]| numbers.iter().map(|number| format!("{number:.4}")).collect::<Vec<_>>().join(" ");
    let value = |value: &Value| match value {
        Value::Float(number) => rounded(&[*number]),
        Value::Rgb(rgb) | Value::Vector(rgb) => rounded(rgb),
        Value::String(text) => text.clone(),
        Value::Transform(matrix) => format!("[{}]", rounded(&matrix.transpose().to_cols_array()[..12])),
        other => format!("{other:?}"),
    };
    let parameters = node.parameters.iter().map(|parameter| format!("{}={}", parameter.name, value(&parameter.value)));
    let children = node.children.iter().map(|child| outline(&child.node));
    format!("{}({})", node.plugin, parameters.chain(children).collect::<Vec<_>>().join(", "))
}

fn report(scene: &SceneDescription) -> String {
    let plugins = scene.root.children.iter().map(|child| format!("{}\n", outline(&child.node)));
    plugins.chain(scene.notices.iter().map(|notice| format!("{notice}\n"))).collect()
}

fn prepare(parts: &Parts<'_>) -> Scene {
    Scene::prepare(&parts.load()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn ceng795_the_whole_tree_of_a_scene() {
    let lights = "<BackgroundColor>1 2 3</BackgroundColor><Lights><AmbientLight>1 1 1</AmbientLight>
        <PointLight id='1'><Position>0 -3 2</Position><Intensity>9 8 7</Intensity></PointLight>
        <AreaLight id='1'><Position>0 -2 3</Position><Normal>0 0 -2</Normal><Size>4</Size><Radiance>1 2 3</Radiance></AreaLight>
        <DirectionalLight id='1'><Direction>0 1 -1</Direction><Radiance>1 1 2</Radiance></DirectionalLight>
        <SpotLight id='1'><Position>0 -3 0</Position><Direction>0 1 0</Direction><Intensity>5 5 5</Intensity>
        <CoverageAngle>60</CoverageAngle><FalloffAngle>40</FalloffAngle></SpotLight></Lights>";
    let transformations =
        "<Translation id='1'>1 2 3</Translation><Scaling id='1'>2 2 2</Scaling><Scaling id='2'>5 1 1</Scaling>
        <Rotation id='1'>90 0 0 1</Rotation><Composite id='1'>1 0 0 7  0 1 0 8  0 0 1 9  0 0 0 1</Composite>";
    let objects = "<Mesh id='1' shadingMode='smooth'><Material>1</Material><Faces>1 2 3 3 4 1</Faces>
        <Transformations>s1 t1</Transformations></Mesh>
        <MeshInstance id='2' baseMeshId='1'><Material>1</Material><Transformations>r1</Transformations></MeshInstance>
        <MeshInstance id='3' baseMeshId='1' resetTransform='true'><Transformations>c1</Transformations></MeshInstance>
        <Triangle id='1'><Material>1</Material><Indices>1 2 3</Indices></Triangle>
        <Sphere id='1'><Material>1</Material><Center>5</Center><Radius>.5</Radius><Transformations>t1 s1</Transformations></Sphere>
        <LightMesh id='1'><Material>1</Material><Radiance>3 3 3</Radiance><Faces vertexOffset='2'>0 1 2</Faces></LightMesh>
        <LightSphere id='1'><Material>1</Material><Center>5</Center><Radius>.2</Radius><Radiance>4 4 4</Radiance>
        <Transformations>s2 t1</Transformations></LightSphere>";
    let parts = Parts { lights, transformations, objects, ..Parts::default() };
    insta::assert_snapshot!(report(&parts.load()));
    prepare(&parts);
}

#[test]
fn ceng795_cameras_look_where_they_should() {
    let ray = |camera: &str, attributes: &str, place: [f32; 2]| {
        let ray = prepare(&Parts { camera, attributes, ..Parts::default() }).camera.ray(Vec2::from(place), [0.5; 2]);
        ray.direction / ray.direction.y
    };
    // 60 × 40 pixels and 90° from bottom to top: the right edge is 1.5 to the right at distance 1.
    let straight = ray(CAMERA, "type='lookAt'", [0.5, 0.5]);
    assert!((straight - photonfarm::math::Vec3::Y).length() < 1e-6, "{straight}");
    let corner = ray(CAMERA, "", [1.0, 0.0]);
    assert!((corner - photonfarm::math::Vec3::new(1.5, 1.0, 1.0)).length() < 1e-5, "{corner}");
    let mirrored = ray(CAMERA, "handedness='left'", [1.0, 0.0]);
    assert!((mirrored - photonfarm::math::Vec3::new(-1.5, 1.0, 1.0)).length() < 1e-5, "{mirrored}");
    let point = CAMERA.replace("<Gaze>0 1 0</Gaze>", "<GazePoint>5 0 0</GazePoint>");
    let turned = ray(&point, "type='lookAt'", [0.5, 0.5]);
    assert!((turned - photonfarm::math::Vec3::new(1.0, 1.0, 0.0)).length() < 1e-5, "{turned}");
    let plane = CAMERA.replace("<FovY>90</FovY>", "<NearPlane>-3 3 -2 2</NearPlane>").replace("e>1<", "e>4<");
    let edge = ray(&plane, "", [1.0, 0.0]);
    assert!((edge - photonfarm::math::Vec3::new(0.75, 1.0, 0.5)).length() < 1e-5, "{edge}");
}

#[test]
fn ceng795_renderers_become_methods() {
    let integrator = |camera: &str, materials: &str| {
        let camera = format!("{CAMERA}{camera}");
        let scene = Parts { camera: &camera, materials, ..Parts::default() }.load();
        of_class(&scene, PluginClass::Integrator).first().map_or("none".to_owned(), |node| outline(node))
    };
    let mirror = MATERIALS.replace("</Material>", "<MirrorReflectance>.1 .1 .1</MirrorReflectance></Material>");
    let photons = "<Renderer>ProgressivePhotonMapping</Renderer><RendererParams><Alpha>0.8</Alpha>
        <ProgressiveCount>4</ProgressiveCount><NumPhotons>400</NumPhotons><R_Initial>0.25</R_Initial></RendererParams>";
    let path = |words: &str| format!("<Renderer>PathTracing</Renderer><RendererParams>{words}</RendererParams>");
    let cases = [
        integrator("", MATERIALS),
        integrator("", &mirror),
        integrator(&path(""), MATERIALS),
        integrator(&path("NextEventEstimation ImportanceSampling"), MATERIALS),
        integrator(&path("RussianRoulette"), MATERIALS),
        integrator("<Renderer>ProgressivePhotonMapping</Renderer>", MATERIALS),
        integrator(photons, MATERIALS),
        integrator(photons, &mirror),
        integrator("<Renderer>Radiosity</Renderer>", MATERIALS),
    ];
    insta::assert_snapshot!(cases.join("\n"));
}

#[test]
fn ceng795_materials_find_the_nearest_bsdf() {
    let colors = |diffuse: f64, specular: f64, mirror: f64| {
        [("Diffuse", diffuse), ("Specular", specular), ("Mirror", mirror)]
            .map(|(name, share)| format!("<{name}Reflectance>{share} {share} {share}</{name}Reflectance>"))
            .concat()
    };
    let glass = "<RefractionIndex>1.5</RefractionIndex>";
    let metal = "<RefractionIndex>.2</RefractionIndex><AbsorptionIndex>3</AbsorptionIndex>";
    let cases = [
        ("matte", "BRDF='1'", colors(0.5, 0.0, 0.0)),
        ("phong", "BRDF='1'", colors(0.4, 0.5, 0.0)),
        ("more than all light", "BRDF='1'", colors(0.5, 0.7, 0.0)),
        ("blinn", "BRDF='2'", colors(0.0, 0.5, 0.0)),
        ("microfacets", "BRDF='3'", colors(0.1, 0.9, 0.0)),
        ("mirror", "type='mirror'", colors(0.0, 0.0, 0.9)),
        ("half a mirror", "BRDF='1'", colors(0.4, 0.0, 0.2)),
        ("metal", "type='conductor'", colors(0.0, 0.0, 1.0) + metal),
        ("rough metal", "type='conductor'", colors(0.0, 0.0, 1.0) + metal + "<Roughness>.2</Roughness>"),
        ("glass", "", format!("<Transparency>1 .81 1</Transparency>{glass}")),
        (
            "absorbing glass",
            "type='dielectric'",
            format!("<AbsorptionCoefficient>2 0 0</AbsorptionCoefficient>{glass}"),
        ),
        ("glossy glass", "BRDF='1'", format!("<Transparency>1 1 1</Transparency>{glass}{}", colors(0.0, 0.3, 0.0))),
    ];
    let mut report = String::new();
    for (what, attributes, body) in cases {
        let materials = format!(
            "<BRDFs><ModifiedPhong id='1' normalized='true'><Exponent>98</Exponent></ModifiedPhong>
             <ModifiedBlinnPhong id='2' normalized='true'><Exponent>98</Exponent></ModifiedBlinnPhong>
             <TorranceSparrow id='3'><Exponent>48</Exponent><RefractiveIndex>0.5</RefractiveIndex></TorranceSparrow></BRDFs>
             <Materials><Material id='1' {attributes}>{body}</Material></Materials>"
        );
        let parts = Parts { materials: &materials, ..Parts::default() };
        let scene = parts.load();
        let bsdf = outline(of_class(&scene, PluginClass::Bsdf)[0]);
        let lost = scene.notices.iter().map(|notice| format!("\n    {} {}", notice.subject, notice.treatment.name()));
        writeln!(report, "{what}: {bsdf}{}", lost.collect::<String>()).unwrap();
        prepare(&parts);
    }
    insta::assert_snapshot!(report);
}

/// Without 1/π in any BRDF the lights are π times as strong, so that direct light has the radiance that the format means.
#[test]
fn ceng795_reflectances_without_pi_keep_direct_light() {
    let materials =
        "<Materials><Material id='1'><DiffuseReflectance>.8 .4 .2</DiffuseReflectance></Material></Materials>";
    let scene = Parts { materials, ..Parts::default() }.load();
    let intensity = &of_class(&scene, PluginClass::Emitter)[0].parameters[1].value;
    assert_eq!(*intensity, Value::Rgb([9.0 * PI, 8.0 * PI, 7.0 * PI]));
    let bsdf = of_class(&scene, PluginClass::Bsdf)[0];
    let Value::Rgb(reflectance) = bsdf.parameters[0].value else { panic!("a color is expected") };
    assert!((reflectance[0] - 0.8).abs() < 1e-12 && (reflectance[2] - 0.2).abs() < 1e-12, "{reflectance:?}");
}

#[test]
fn ceng795_offsets_count_from_where_they_say() {
    let faces = |faces: &str| {
        let objects = format!("<Mesh id='1'><Material>1</Material>{faces}</Mesh>");
        let text = Parts { objects: &objects, ..Parts::default() }.text();
        let scene = load_bytes("scene.xml", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
        let bytes = scene.bundle.read("generated/mesh-0.ply", &scene.root.location).expect("the mesh is there");
        bytes.to_vec()
    };
    let plain = faces("<Faces>2 3 4</Faces>");
    assert_eq!(plain, faces("<Faces vertexOffset='1'>1 2 3</Faces>"));
    assert_eq!(plain, faces("<Faces vertexOffset='-1'>3 4 5</Faces>"));
    let text = Parts::default().text().replace("<Objects>", "<ZeroBasedIndexing>true</ZeroBasedIndexing><Objects>");
    let zero_based = text.replace("1 2 3\n3 4 1", "1 2 3");
    let scene = load_bytes("scene.xml", zero_based.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let bytes = scene.bundle.read("generated/mesh-0.ply", &scene.root.location).expect("the mesh is there");
    assert_eq!(plain, bytes.to_vec());
}

/// A sphere scaled by 5 × 1 × 1 has the area of a spheroid, which the power of the light on it tells.
#[test]
fn ceng795_uneven_spheres_become_ellipsoids() {
    let objects = format!(
        "{MESH}<LightSphere id='1'><Center>5</Center><Radius>.2</Radius><Radiance>2 2 2</Radiance>
         <Transformations>s1</Transformations></LightSphere>"
    );
    let transformations = "<Scaling id='1'>5 1 1</Scaling>";
    let scene = prepare(&Parts { lights: "", transformations, objects: &objects, ..Parts::default() });
    // A prolate spheroid of semi-axes a > b.
    let (a, b) = (1.0_f64, 0.2_f64);
    let eccentricity = (1.0 - b * b / (a * a)).sqrt();
    let area = 2.0 * PI * b * b * (1.0 + a / (b * eccentricity) * eccentricity.asin());
    let power = f64::from(scene.lights.lights()[0].power().x);
    assert!((power / (PI * 2.0 * area) - 1.0).abs() < 3e-3, "{power}");
}

#[test]
fn ceng795_is_told_by_its_outermost_tag() {
    let text = Parts::default().text();
    let headed = format!("\u{feff}<?xml version='1.0'?>\n<!-- <Scene version='3'> -->\n{text}");
    load_bytes("x", headed.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    for other in [text.replace("<Scene>", "<Scene version='3.0.0'>"), text.replace("Scene>", "Scenery>")] {
        let error = load_bytes("x", other.as_bytes(), &[]).expect_err("another format").to_string();
        assert!(error.contains("the outermost tag is <Scene"), "{error}");
    }
}

#[test]
fn ceng795_mesh_files_travel_with_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("scene.xml");
    let mesh = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n";
    std::fs::write(folder.path().join("mesh.ply"), mesh).expect("writes");
    std::fs::write(&scene, Parts::default().text()).expect("writes");
    assert_eq!(pack(&scene, &[]).expect("packs"), Parts::default().text().as_bytes(), "nothing else travels");
    let objects = "<Mesh id='1'><Material>1</Material><Faces plyFile='mesh.ply'/></Mesh>";
    std::fs::write(&scene, Parts { objects, ..Parts::default() }.text()).expect("writes");
    let packed = pack(&scene, &[]).expect("packs");
    for description in [load_file(&scene, &[]), load_bytes("scene", &packed, &[])] {
        let description = description.unwrap_or_else(|error| panic!("{error}"));
        Scene::prepare(&description).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn ceng795_unknown_parts_are_reported() {
    let objects =
        format!("{MESH}<Cube id='1'/><Spheer/>").replace("<Faces>", "<Texture>1</Texture><Faces plyfile='x'>");
    let camera = format!("{CAMERA}<Tonemap><TMO>Photographic</TMO></Tonemap>");
    let scene = Parts { objects: &objects, camera: &camera, attributes: "kind='pinhole'", ..Parts::default() }.load();
    insta::assert_snapshot!(scene.notices.iter().map(|notice| format!("{notice}\n")).collect::<String>());
}

#[test]
fn ceng795_that_cannot_be() {
    let cases = [
        ("no camera", CAMERA, ""),
        ("no objects", "<Objects>", "<Objectz>"),
        ("no gaze", "<Gaze>0 1 0</Gaze>", ""),
        ("up along gaze", "<Up>0 0 1</Up>", "<Up>0 2 0</Up>"),
        ("two ups", "<Up>", "<Up>1 0 0</Up><Up>"),
        ("vector of two numbers", "<Up>0 0 1</Up>", "<Up>0 1</Up>"),
        ("angle of view of 180", "90", "180"),
        ("no pixels", "60 40", "0 40"),
        ("half a pixel", "60 40", "60.5 40"),
        ("too many pixels", "60 40", "4e9 4e9"),
        ("unknown handedness", "id='1' >", "id='1' handedness='both'>"),
        ("negative depth", "Depth>3", "Depth>-3"),
        ("negative light", "9 8 7", "9 -8 7"),
        ("infinite light", "9 8 7", "9 1e999 7"),
        ("light without a place", "<Position>0 -3 2</Position>", ""),
        ("unknown material", "<Material>1", "<Material>2"),
        ("no material", "<Material>1</Material>", ""),
        ("unknown BRDF", "BRDF='1'", "BRDF='7'"),
        ("unknown type", "BRDF='1'", "type='dieletric'"),
        ("glass without index", "BRDF='1'", "type='dielectric'"),
        ("negative exponent", "98", "-2"),
        ("normalized perhaps", "'true'", "'perhaps'"),
        ("vertex that is none", "1 0 -1", "1 zero -1"),
        ("vertex nan", "1 0 -1", "1 nan -1"),
        ("vertex beyond single precision", "1 0 -1", "1 1e39 -1"),
        ("half a vertex", "1 0 -1", "1 0"),
        ("binary vertices", "<VertexData>", "<VertexData binaryFile='a.bin'>"),
        ("index out of range", "3 4 1", "3 4 6"),
        ("index 0", "3 4 1", "3 4 0"),
        ("huge index", "3 4 1", "3 4 99999999999999999999"),
        ("huge offset", "<Faces>", "<Faces vertexOffset='9999999999'>"),
        ("half a triangle", "3 4 1", "3 4"),
        ("triangles without area", "1 2 3\n3 4 1", "1 1 2"),
        ("unknown shading", "<Mesh id='1'>", "<Mesh id='1' shadingMode='gouraud'>"),
        ("mesh file above", "<Faces>", "<Faces plyFile='../secret.ply'>"),
        ("mesh twice", "<Mesh id='1'>", "<Mesh id='1'><Material>1</Material><Faces>1 2 3</Faces></Mesh><Mesh id='1'>"),
        ("unknown transformation", "</Faces>", "</Faces><Transformations>t1</Transformations>"),
        ("no axis", "<Transformations>", "<Transformations><Rotation id='1'>9 0 0 0</Rotation>"),
        ("instance of nothing", "</Mesh>", "</Mesh><MeshInstance baseMeshId='4'/>"),
        ("instance without mesh", "</Mesh>", "</Mesh><MeshInstance/>"),
        (
            "sphere of radius 0",
            "</Mesh>",
            "</Mesh><Sphere><Material>1</Material><Center>1</Center><Radius>0</Radius></Sphere>",
        ),
        (
            "sphere nowhere",
            "</Mesh>",
            "</Mesh><Sphere><Material>1</Material><Center>9</Center><Radius>1</Radius></Sphere>",
        ),
        ("cut off", "</Objects>", ""),
        ("document type", "<Scene>", "<!DOCTYPE x [<!ENTITY a 'b'>]><Scene>"),
    ];
    let mut report = String::new();
    for (what, from, to) in cases {
        let text = Parts::default().text();
        assert!(text.contains(from), "{what}");
        let result = load_bytes("scene.xml", text.replacen(from, to, 1).as_bytes(), &[]);
        match result.and_then(|scene| Scene::prepare(&scene)) {
            Ok(_) => panic!("{what} is no error"),
            Err(error) => writeln!(report, "{what}\n    {error}").unwrap(),
        }
    }
    let define = [("size".to_owned(), "1".to_owned())];
    let error = load_bytes("scene.xml", Parts::default().text().as_bytes(), &define).expect_err("no parameters");
    writeln!(report, "define\n    {error}").unwrap();
    insta::assert_snapshot!(report);
}

/// A short file cannot stand for more triangles than a machine holds.
#[test]
fn ceng795_copies_are_bounded() {
    let mut objects = MESH.to_owned();
    for sphere in 0..1000 {
        write!(objects, "<Sphere id='{sphere}'><Material>1</Material><Center>5</Center><Radius>1</Radius><Transformations>s1</Transformations></Sphere>").unwrap();
    }
    let text =
        Parts { objects: &objects, transformations: "<Scaling id='1'>1 2 3</Scaling>", ..Parts::default() }.text();
    let error = load_bytes("scene.xml", text.as_bytes(), &[]).expect_err("it is too much").to_string();
    assert!(error.contains("more than 4000000 triangles"), "{error}");
}

/// No cut and no changed byte of a scene makes importing or preparing it panic.
#[test]
fn ceng795_mutations_are_read_or_refused() {
    let objects = format!(
        "{MESH}<MeshInstance baseMeshId='1'><Material>1</Material><Transformations>s1 r1</Transformations></MeshInstance>
         <Triangle><Material>1</Material><Indices vertexOffset='1'>0 1 2</Indices></Triangle>
         <LightSphere><Center>5</Center><Radius>.2</Radius><Radiance>2 2 2</Radiance><Transformations>s1</Transformations></LightSphere>"
    );
    let transformations = "<Scaling id='1'>5 1 1</Scaling><Rotation id='1'>30 0 1 0</Rotation>";
    let camera =
        format!("{CAMERA}<Renderer>PathTracing</Renderer><RendererParams>NextEventEstimation</RendererParams>");
    let scene = Parts { objects: &objects, transformations, camera: &camera, ..Parts::default() }.text();
    load_bytes("scene.xml", scene.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"));
    for length in (0..scene.len()).step_by(7) {
        drop(load_bytes("scene.xml", &scene.as_bytes()[..length], &[]));
    }
    for index in 0..2000 {
        let u = numbers(3, index);
        let mut bytes = scene.clone().into_bytes();
        let at = (u[0] * bytes.len() as f32) as usize;
        bytes[at] = b"0123456789.-e<>/'S \n\xff\0"[(u[1] * 22.0) as usize];
        if u[2] < 0.3 {
            let other = (u[3] * bytes.len() as f32) as usize;
            bytes.drain(at.min(other)..at.max(other).min(at.min(other) + 20));
        }
        drop(load_bytes("scene.xml", &bytes, &[]).and_then(|scene| Scene::prepare(&scene)));
    }
}
