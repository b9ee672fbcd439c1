//! Scenes of Mitsuba 0.6 and before come out as the tree that their counterparts for Mitsuba 3 mean, and whatever has no
//! counterpart is told.

use crate::description_tree::tree;
use photonfarm::import::load_bytes;
use photonfarm::scene::Scene;
use photonfarm::scene::description::{Node, PluginClass, SceneDescription, Value};

fn load(text: &str) -> SceneDescription {
    load_bytes("scene.xml", text.as_bytes(), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn old(body: &str) -> SceneDescription {
    load(&format!("<scene version='0.5.0'>{body}</scene>"))
}

fn new(body: &str) -> SceneDescription {
    load(&format!("<scene version='3.0.0'>{body}</scene>"))
}

fn notices(description: &SceneDescription) -> String {
    description.notices.iter().map(|notice| format!("{notice}\n")).collect()
}

fn value<'a>(node: &'a Node, name: &str) -> &'a Value {
    &node.parameters.iter().find(|parameter| parameter.name == name).unwrap_or_else(|| panic!("no {name}")).value
}

const OLD_ROOM: &str = "<?xml version='1.0' encoding='utf-8'?>
<scene version='0.6.0'>
  <integrator type='sppm'>
    <integer name='maxDepth' value='12'/><integer name='photonCount' value='50000'/>
    <float name='initialRadius' value='0.1'/><boolean name='autoCancelGathering' value='true'/>
  </integrator>
  <sensor type='perspective'>
    <float name='fov' value='45'/><string name='fovAxis' value='smaller'/>
    <float name='nearClip' value='0.1'/><float name='farClip' value='100'/>
    <transform name='toWorld'><lookAt origin='0, 1, 4' target='0, 1, 0' up='0, 1, 0'/></transform>
    <sampler type='halton'><integer name='sampleCount' value='16'/></sampler>
    <film type='hdrfilm'>
      <integer name='width' value='32'/><integer name='height' value='24'/>
      <string name='pixelFormat' value='rgb'/><boolean name='banner' value='false'/><rfilter type='box'/>
    </film>
  </sensor>
  <bsdf type='twosided' id='white'>
    <bsdf type='diffuse'><spectrum name='reflectance' value='0.7'/></bsdf>
  </bsdf>
  <bsdf type='dielectric' id='glass'><string name='intIOR' value='water'/><float name='extIOR' value='1.0'/></bsdf>
  <shape type='rectangle'>
    <transform name='toWorld'><scale value='5'/><rotate x='1' angle='-90'/></transform>
    <ref id='white'/>
  </shape>
  <shape type='sphere'>
    <point name='center' x='0' y='1' z='0'/><float name='radius' value='0.5'/>
    <ref id='glass'/>
  </shape>
  <shape type='cube'>
    <transform name='toWorld'><scale value='0.3'/><translate x='1.2' y='0.3' z='0'/></transform>
    <bsdf type='conductor'><float name='extEta' value='1'/></bsdf>
  </shape>
  <shape type='disk'>
    <transform name='toWorld'><rotate x='1' angle='90'/><translate x='0' y='3' z='0'/></transform>
    <emitter type='area'><rgb name='radiance' value='10, 9, 8'/><float name='samplingWeight' value='2'/></emitter>
  </shape>
  <emitter type='spot'>
    <transform name='toWorld'><lookat origin='1, 3, 1' target='0, 0, 0' up='0, 1, 0'/></transform>
    <rgb name='intensity' value='#ff8000'/><float name='cutoffAngle' value='30'/><float name='beamWidth' value='20'/>
  </emitter>
</scene>";

const NEW_ROOM: &str = "<scene version='3.0.0'>
  <integrator type='sppm'>
    <integer name='max_depth' value='12'/><integer name='photons_per_pass' value='50000'/>
    <float name='initial_radius' value='0.1'/><float name='alpha' value='0.7'/><integer name='rr_depth' value='3'/>
  </integrator>
  <sensor type='perspective'>
    <float name='fov' value='45'/><string name='fov_axis' value='smaller'/>
    <float name='near_clip' value='0.1'/><float name='far_clip' value='100'/>
    <transform name='to_world'><lookat origin='0, 1, 4' target='0, 1, 0' up='0, 1, 0'/></transform>
    <sampler type='independent'><integer name='sample_count' value='16'/></sampler>
    <film type='hdrfilm'>
      <integer name='width' value='32'/><integer name='height' value='24'/>
      <string name='pixel_format' value='rgb'/><rfilter type='box'/>
    </film>
  </sensor>
  <bsdf type='twosided' id='white'>
    <bsdf type='diffuse'><rgb name='reflectance' value='0.7, 0.7, 0.7'/></bsdf>
  </bsdf>
  <bsdf type='dielectric' id='glass'><string name='int_ior' value='water'/><float name='ext_ior' value='1'/></bsdf>
  <shape type='rectangle'>
    <transform name='to_world'><scale value='5'/><rotate x='1' angle='-90'/></transform>
    <ref id='white'/>
  </shape>
  <shape type='sphere'>
    <point name='center' x='0' y='1' z='0'/><float name='radius' value='0.5'/>
    <ref id='glass'/>
  </shape>
  <shape type='cube'>
    <transform name='to_world'><scale value='0.3'/><translate x='1.2' y='0.3' z='0'/></transform>
    <bsdf type='conductor'><string name='material' value='Cu'/></bsdf>
  </shape>
  <shape type='disk'>
    <transform name='to_world'><rotate x='1' angle='90'/><translate x='0' y='3' z='0'/></transform>
    <emitter type='area'><rgb name='radiance' value='10, 9, 8'/></emitter>
    <bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf>
  </shape>
  <emitter type='spot'>
    <transform name='to_world'><lookat origin='1, 3, 1' target='0, 0, 0' up='0, 1, 0'/></transform>
    <rgb name='intensity' value='1, 0.5019607843137255, 0'/>
    <float name='cutoff_angle' value='30'/><float name='beam_width' value='20'/>
  </emitter>
</scene>";

#[test]
fn old_and_new_xml_of_one_scene_give_one_tree() {
    let (old, new) = (load(OLD_ROOM), load(NEW_ROOM));
    assert_eq!(tree(&old), tree(&new));
    assert_eq!(notices(&old), "");
    assert!(Scene::prepare(&old).is_ok_and(|scene| scene.notices.is_empty()));
}

#[test]
fn materials_have_their_new_names_and_the_old_defaults() {
    let pairs = [
        (
            "<bsdf type='roughplastic'><srgb name='diffuseReflectance' value='1, 1, 0'/><string name='distribution' value='GGX'/>\
             <boolean name='nonlinear' value='true'/><float name='alpha' value='0.2'/></bsdf>",
            "<bsdf type='roughplastic'><rgb name='diffuse_reflectance' value='1, 1, 0'/><string name='distribution' value='ggx'/>\
             <boolean name='nonlinear' value='true'/><float name='alpha' value='0.2'/></bsdf>",
        ),
        (
            "<bsdf type='roughconductor'><rgb name='eta' value='2, 4, 6'/><rgb name='k' value='8'/><float name='extEta' value='2'/>\
             <float name='alphaU' value='0.1'/><float name='alphaV' value='0.3'/></bsdf>",
            "<bsdf type='roughconductor'><rgb name='eta' value='1, 2, 3'/><rgb name='k' value='4'/>\
             <float name='alpha_u' value='0.1'/><float name='alpha_v' value='0.3'/></bsdf>",
        ),
        (
            "<bsdf type='coating'><bsdf type='diffuse'><rgb name='reflectance' value='0.1, 0.2, 0.3'/></bsdf></bsdf>",
            "<bsdf type='plastic'><rgb name='diffuse_reflectance' value='0.1, 0.2, 0.3'/><string name='int_ior' value='bk7'/></bsdf>",
        ),
        (
            "<bsdf type='mixturebsdf'><string name='weights' value='0.25, 0.25'/><bsdf type='null'/><bsdf type='plastic'/></bsdf>",
            "<bsdf type='blendbsdf'><float name='weight' value='0.5'/>\
             <bsdf type='blendbsdf'><float name='weight' value='0.5'/><bsdf type='null'/><bsdf type='plastic'/></bsdf>\
             <bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf></bsdf>",
        ),
        (
            "<bsdf type='phong'><float name='exponent' value='50'/></bsdf>",
            "<bsdf type='ward'><float name='alpha' value='0.1'/></bsdf>",
        ),
        (
            "<bsdf type='normalmap'><texture type='bitmap'><string name='filename' value='a.png'/>\
             <float name='gamma' value='1'/></texture><bsdf type='diffuse'/></bsdf>",
            "<bsdf type='normalmap'><boolean name='flip_invalid_normals' value='false'/><boolean name='use_shadowing_function' value='false'/><texture name='normalmap' type='bitmap'><string name='filename' value='a.png'/>\
             <boolean name='raw' value='true'/></texture><bsdf type='diffuse'/></bsdf>",
        ),
        (
            "<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'>\
             <float name='uvscale' value='4'/><float name='voffset' value='0.5'/></texture></bsdf>",
            "<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'><boolean name='swaps_numbers' value='false'/>\
             <transform name='to_uv'><scale x='4' y='4'/><translate y='0.5'/></transform></texture></bsdf>",
        ),
    ];
    for (before, after) in pairs {
        assert_eq!(tree(&old(before)), tree(&new(after)), "{before}");
    }
}

#[test]
fn references_follow_what_took_the_place_of_their_plugin() {
    let scene = old(
        "<texture type='wireframe' id='lines'/><bsdf type='roughcoating' id='coat'><bsdf type='conductor' id='metal'/></bsdf>\
         <medium type='homogeneous' id='fog'/>\
         <shape type='cube'><ref id='coat'/></shape><shape type='cube'><ref id='metal'/></shape>\
         <shape type='sphere'><ref name='interior' id='fog'/></shape>\
         <shape type='disk'><bsdf type='diffuse'><ref id='lines' name='reflectance'/></bsdf></shape>",
    );
    let bsdf = |shape: usize| {
        let shapes: Vec<_> = scene.root.children.iter().filter(|child| child.node.class.tag() == "shape").collect();
        shapes[shape].node.children[0].node.clone()
    };
    assert!(std::sync::Arc::ptr_eq(&bsdf(0), &bsdf(1)));
    assert_eq!(bsdf(2).plugin, "null");
    assert_eq!(*value(&bsdf(3), "reflectance"), Value::Rgb([0.5; 3]));
    let told = notices(&scene);
    assert_eq!(told.lines().count(), 3, "{told}");
    assert!(told.contains("a medium without \"sigmaA\""), "{told}");
}

#[test]
fn media_have_extinction_and_albedo() {
    let unknown = old(
        "<shape type='cube'><medium name='interior' type='homogeneous'><string name='material' value='skin1'/></medium></shape>",
    );
    assert_eq!(unknown.root.children[0].node.children[0].node.plugin, "null");
    let before = old("<integrator type='bdpt'><integer name='maxDepth' value='9'/></integrator>\
         <medium type='homogeneous' id='milk'><rgb name='sigmaA' value='1, 2, 3'/><rgb name='sigmaS' value='3, 2, 0'/>\
         <phase type='hg'><float name='g' value='0.5'/></phase></medium>\
         <medium type='heterogeneous' id='smoke'><string name='method' value='woodcock'/>\
         <volume type='constvolume' name='density'><float name='value' value='2'/></volume>\
         <volume type='constvolume' name='albedo'><rgb name='value' value='.5,.6,.7'/></volume></medium>\
         <shape type='cube'><ref name='interior' id='milk'/></shape><shape type='sphere'><ref name='interior' id='smoke'/></shape>");
    let after = new("<integrator type='volpath'><integer name='max_depth' value='9'/></integrator>\
         <medium type='homogeneous' id='milk'><rgb name='sigma_t' value='4, 4, 3'/><rgb name='albedo' value='.75, .5, 0'/>\
         <phase type='hg'><float name='g' value='0.5'/></phase></medium>\
         <medium type='homogeneous' id='smoke'>\
         <volume type='constvolume' name='sigma_t'><float name='value' value='2'/></volume>\
         <volume type='constvolume' name='albedo'><rgb name='value' value='.5,.6,.7'/></volume></medium>\
         <shape type='cube'><ref name='interior' id='milk'/><bsdf type='null'/></shape>\
         <shape type='sphere'><ref name='interior' id='smoke'/><bsdf type='null'/></shape>");
    let parameters_sorted = |description| {
        let tree: String = tree(description);
        let mut lines: Vec<&str> = tree.lines().collect();
        lines.sort_unstable();
        lines.join("\n")
    };
    assert_eq!(parameters_sorted(&before), parameters_sorted(&after));
    assert!(notices(&before).contains("a \"volpath\" takes its place"), "{}", notices(&before));
    let passing = old("<integrator type='sppm'/><shape type='cube'><medium type='homogeneous' name='interior'>\
         <float name='sigmaT' value='1'/><float name='albedo' value='0.5'/></medium></shape>");
    assert!(notices(&passing).contains("passes through them"), "{}", notices(&passing));
    assert!(passing.root.children[1].node.children.iter().all(|child| child.node.class != PluginClass::Medium));
}

#[test]
fn what_has_no_counterpart_is_told_with_its_place() {
    let scene = load(
        "<scene version='0.5.0'>\n<mode type='final'/>\n<integrator type='pssmlt'>\n<integer name='maxDepth' value='7'/>\n\
         <boolean name='strictNormals' value='true'/></integrator>\n<shape type='hair'><string name='filename' value='a.hair'/></shape>\n\
         <shape type='sphere'>\n<hide id='Water'/><subsurface type='dipole'/></shape>\n\
         <sensor type='perspective'><film type='ldrfilm'><string name='filename' value='a.png'/>\
         <float name='exposure' value='2'/><rfilter type='gaussian'/></film></sensor>\n\
         <emitter type='constant'><blackbody name='radiance' temperature='5000K'/></emitter></scene>",
    );
    insta::assert_snapshot!(notices(&scene));
    assert_eq!(scene.root.children.iter().filter(|child| child.node.plugin == "bdpt").count(), 1);
}

#[test]
fn still_older_versions_are_read() {
    let scene = load(
        "<scene version='0.2.1'><camera type='perspective'><boolean name='mapSmallerSide' value='true'/>\
         <transform name='toWorld'><lookAt ox='0' oy='0' oz='5' tx='0' ty='0' tz='0' ux='0' uy='1' uz='0'/></transform></camera>\
         <shape type='obj'><string name='filename' value='a.obj'/><bsdf type='lambertian'/></shape>\
         <shape type='cylinder'><point name='p1' x='1' y='0' z='0'/><point name='p2' x='2' y='0' z='0'/><bsdf type='mirror'/></shape>\
         <luminaire type='constant'><rgb name='intensity' value='1, 2, 3'/></luminaire></scene>",
    );
    let same = new("<sensor type='perspective'><string name='fov_axis' value='smaller'/>\
         <transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform></sensor>\
         <shape type='obj'><string name='filename' value='a.obj'/><boolean name='flip_tex_coords' value='false'/><bsdf type='diffuse'/></shape>\
         <shape type='cylinder'><point name='p0' x='1'/><point name='p1' x='2'/>\
         <bsdf type='conductor'><string name='material' value='Cr'/></bsdf></shape>\
         <emitter type='constant'><rgb name='radiance' value='1, 2, 3'/></emitter>");
    // Two mirrorings cancel but for the signs of zeros.
    let unsigned = |description| tree(description).replace("-0.0", "0.0");
    assert_eq!(unsigned(&scene), unsigned(&same));
    assert_eq!(notices(&scene), "");
}

#[test]
fn plugins_of_forks_become_their_nearest_kind() {
    let scene = old("<integrator type='guided_path'><integer name='maxDepth' value='5'/></integrator>\
         <shape type='cube'><bsdf type='disneyBRDF'><rgb name='baseColor' value='.1,.2,.3'/><float name='roughness' value='.4'/>\
         <float name='glow' value='1'/></bsdf></shape>\
         <shape type='cube'><bsdf type='velvet_cloth'/></shape><shape type='pointcloud'/><sampler type='bluenoise'/>");
    let child = |index: usize| &scene.root.children[index].node;
    assert_eq!((child(0).plugin.as_str(), value(child(0), "max_depth")), ("guided_path", &Value::Integer(5)));
    let disney = &child(1).children[0].node;
    assert_eq!((disney.plugin.as_str(), value(disney, "base_color")), ("principled", &Value::Rgb([0.1, 0.2, 0.3])));
    assert_eq!(child(2).children[0].node.plugin, "diffuse");
    let told = notices(&scene);
    for part in ["disneyBRDF", "glow", "velvet_cloth", "pointcloud", "bluenoise"] {
        assert!(told.contains(part), "{part}: {told}");
    }
}
