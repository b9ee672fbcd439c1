//! Shapes. Curved ones that are cut open, scaled unevenly, or textured in pbrt's way become meshes.

use std::f64::consts::TAU;

use glam::{DMat3, DMat4, DVec2, DVec3, Vec2, Vec3};

use super::super::draft::Draft;
use super::super::values::shown;
use super::mesh::Mesh;
use super::output::{Output, is_compressed};
use super::parameters::Parameters;
use crate::scene::description::PluginClass;
use crate::scene::error::{SceneError, nearest_name, shown_number};

/// How many flat pieces take the place of a whole turn.
const CORNERS: f64 = 96.0;

/// Where a shape stands and what it is like.
pub(super) struct Setting {
    pub to_world: DMat4,
    pub reverse: bool,
    /// Whether its texture coordinates matter.
    pub textured: bool,
}

const KINDS: [&str; 8] =
    ["trianglemesh", "plymesh", "sphere", "disk", "cylinder", "bilinearmesh", "loopsubdiv", "curve"];

/// Reads a shape without its material and light; nothing when it has no counterpart, which is reported.
///
/// # Errors
/// On meshes that do not fit together, and shapes that pbrt does not have.
pub(super) fn read(
    kind: &str,
    parameters: &Parameters,
    setting: &Setting,
    output: &mut Output<'_>,
) -> Result<Option<Draft>, SceneError> {
    let place = &parameters.place;
    let shape = match kind {
        "trianglemesh" => triangles(parameters, "indices", setting, output)?,
        "bilinearmesh" => bilinear(parameters, output)?,
        "loopsubdiv" => {
            parameters.pass_over(&["levels", "scheme"]);
            output.approximated(place, "shape \"loopsubdiv\"", "the mesh that it starts from takes its place");
            let mut shape = triangles(parameters, "indices", setting, output)?;
            // The surface that it stands for is smooth.
            shape.parameters.retain(|parameter| parameter.name != "face_normals");
            shape
        }
        "plymesh" => ply(parameters, output)?,
        "sphere" => sphere(parameters, setting, output)?,
        "disk" => disk(parameters, setting, output)?,
        "cylinder" => cylinder(parameters, setting, output)?,
        "curve" => {
            output.ignored(place, "shape \"curve\"", "curves have no counterpart");
            return Ok(None);
        }
        _ => {
            let problem = format!("there is no shape {}", shown(kind));
            return Err(SceneError::new(place, problem, nearest_name(kind, &KINDS)));
        }
    };
    output.report_unused(&format!("shape {}", shown(kind)), parameters)?;
    let shape = if setting.to_world == DMat4::IDENTITY || has(&shape, "to_world") {
        shape
    } else {
        shape.with_transform("to_world", setting.to_world)
    };
    let shape = match shape.plugin.as_str() {
        "ply" | "sphere" => shape.keeping_outside(setting.to_world),
        _ => shape,
    };
    Ok(Some(if setting.reverse { shape.with_flag("flip_normals", true) } else { shape }))
}

fn has(shape: &Draft, name: &str) -> bool {
    shape.parameters.iter().any(|parameter| parameter.name == name)
}

/// The vertices of a mesh that stands in the text.
fn vertices(parameters: &Parameters) -> Result<Mesh, SceneError> {
    let place = &parameters.place;
    let Some(points) = parameters.numbers("P", 3)? else {
        return Err(SceneError::new(place, "the mesh has no points \"P\"", "add them"));
    };
    let vector = |numbers: &[f64]| DVec3::new(numbers[0], numbers[1], numbers[2]).as_vec3();
    let positions: Vec<Vec3> = points.chunks_exact(3).map(vector).collect();
    if positions.iter().any(|position| !position.is_finite()) {
        return Err(SceneError::new(place, "points do not fit into single precision", "scale the scene down"));
    }
    let count = positions.len();
    let fitting = |name: &str, found: usize| {
        let problem = format!("the mesh has {count} points but {found} of \"{name}\"");
        if found == count { Ok(()) } else { Err(SceneError::new(place, problem, "give one for each point")) }
    };
    let mut mesh = Mesh { positions, ..Mesh::default() };
    if let Some(normals) = parameters.numbers("N", 3)? {
        fitting("N", normals.len() / 3)?;
        mesh.normals = normals.chunks_exact(3).map(vector).collect();
    }
    let coordinates = if parameters.has("uv") { "uv" } else { "st" };
    if let Some(numbers) = parameters.numbers(coordinates, 2)? {
        fitting(coordinates, numbers.len() / 2)?;
        mesh.coordinates = numbers.chunks_exact(2).map(|uv| DVec2::new(uv[0], uv[1]).as_vec2()).collect();
    }
    let all = mesh.normals.iter().flat_map(|normal| normal.to_array());
    if all.chain(mesh.coordinates.iter().flat_map(Vec2::to_array)).any(|number| !number.is_finite()) {
        return Err(SceneError::new(place, "the mesh has numbers that single precision cannot hold", "repair it"));
    }
    // Tangents matter to brushed surfaces with a direction only.
    parameters.pass_over(&["S", "faceIndices"]);
    Ok(mesh)
}

/// Indices in groups of `size`, in range; by default 0, 1, 2 … for a single group.
fn indices(parameters: &Parameters, name: &str, size: usize, count: usize) -> Result<Vec<u32>, SceneError> {
    let Some(numbers) = parameters.numbers(name, size)? else {
        if count == size {
            return Ok((0..size as u32).collect());
        }
        let problem = format!("the mesh has {count} points and no \"{name}\"");
        return Err(SceneError::new(&parameters.place, problem, "say which points make its faces"));
    };
    let index = |number: &f64| {
        let fits = number.fract() == 0.0 && (0.0..count as f64).contains(number);
        let problem = || format!("index {number} in a mesh of {count} points, counted from 0");
        if fits { Ok(*number as u32) } else { Err(SceneError::new(&parameters.place, problem(), "repair the mesh")) }
    };
    numbers.iter().map(index).collect()
}

fn triangles(
    parameters: &Parameters,
    name: &str,
    setting: &Setting,
    output: &mut Output<'_>,
) -> Result<Draft, SceneError> {
    let mut mesh = vertices(parameters)?;
    let indices = indices(parameters, name, 3, mesh.positions.len())?;
    mesh.triangles = indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect();
    mesh.face_normals();
    if setting.textured && mesh.coordinates.is_empty() {
        mesh = mesh.with_default_coordinates();
    }
    output.mesh_shape(mesh, &parameters.place)
}

/// Patches with four corners: (0, 0), (1, 0), (0, 1), (1, 1).
fn bilinear(parameters: &Parameters, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    let mut mesh = vertices(parameters)?;
    let indices = indices(parameters, "indices", 4, mesh.positions.len())?;
    let halves = |corners: &[u32]| [[corners[0], corners[1], corners[3]], [corners[0], corners[3], corners[2]]];
    mesh.triangles = indices.chunks_exact(4).flat_map(halves).collect();
    mesh.face_normals();
    output.approximated(&parameters.place, "shape \"bilinearmesh\"", "two triangles take the place of each patch");
    output.mesh_shape(mesh, &parameters.place)
}

fn ply(parameters: &Parameters, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    let Some(name) = parameters.text("filename")? else {
        return Err(SceneError::new(&parameters.place, "a plymesh has no \"filename\"", "name the PLY file"));
    };
    let content = output.read(name, &parameters.place)?;
    let head = String::from_utf8_lossy(&content[..content.len().min(65_536)]);
    let head = head.split("end_header").next().unwrap_or_default();
    let has_normals = head.lines().any(|line| line.starts_with("property") && line.trim_end().ends_with(" nx"));
    let place = &parameters.place;
    let kept = if is_compressed(name) { output.keep_unpacked(name, content, place) } else { name.to_owned() };
    let shape = Draft::new(PluginClass::Shape, "ply", place).with_text("filename", &kept);
    let shape = shape.with_flag("flip_tex_coords", true);
    parameters.pass_over(&["edgelength"]);
    // Without normals pbrt's triangles are flat.
    Ok(if has_normals { shape } else { shape.with_flag("face_normals", true) })
}

/// Whether a sphere stays a sphere.
fn keeps_shape(to_world: DMat4) -> bool {
    let linear = DMat3::from_mat4(to_world);
    let scale = linear.x_axis.length_squared();
    let square = linear.transpose() * linear;
    let off = square - DMat3::from_diagonal(DVec3::splat(scale));
    off.to_cols_array().iter().all(|entry| entry.abs() <= 1e-4 * scale)
}

fn positive(parameters: &Parameters, name: &str, default: f64) -> Result<f64, SceneError> {
    let number = parameters.float(name)?.unwrap_or(default);
    if number > 0.0 && number < 1e30 {
        return Ok(number);
    }
    Err(SceneError::new(&parameters.place, format!("\"{name}\" is {}", shown_number(number)), "give a number above 0"))
}

/// The angle that is swept about z, radians.
fn sweep(parameters: &Parameters) -> Result<f64, SceneError> {
    Ok(positive(parameters, "phimax", 360.0)?.min(360.0).to_radians())
}

/// A mesh in place of a curved shape: a point and its normal at each (u, v).
fn curved(
    [columns, rows]: [f64; 2],
    point: impl Fn(DVec2) -> (DVec3, DVec3),
    what: &str,
    parameters: &Parameters,
    output: &mut Output<'_>,
) -> Result<Draft, SceneError> {
    output.approximated(&parameters.place, what, "a mesh with smooth normals takes its place");
    let mesh = Mesh::surface([columns, rows].map(|count| count.ceil().max(1.0) as u32), point);
    output.mesh_shape(mesh, &parameters.place)
}

/// (cos, sin) of an angle, the same on every machine.
fn around(angle: f64) -> DVec2 {
    let (sine, cosine) = libm::sincos(angle);
    DVec2::new(cosine, sine)
}

fn sphere(parameters: &Parameters, setting: &Setting, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    let radius = positive(parameters, "radius", 1.0)?;
    let [low, high] = [("zmin", -radius), ("zmax", radius)].map(|(name, default)| {
        let height = parameters.float(name)?.unwrap_or(default);
        Ok::<f64, SceneError>(height.clamp(-radius, radius))
    });
    let (low, high, turn) = (low?, high?, sweep(parameters)?);
    let (low, high) = (low.min(high), low.max(high));
    let whole = low <= -radius && high >= radius && turn >= TAU;
    if whole && keeps_shape(setting.to_world) {
        return Ok(Draft::new(PluginClass::Shape, "sphere", &parameters.place).with_float("radius", radius));
    }
    let (bottom, top) = (libm::acos(low / radius), libm::acos(high / radius));
    let rows = CORNERS * (bottom - top) / TAU;
    let point = |uv: DVec2| {
        let [height, ring] = around(bottom + uv.y * (top - bottom)).to_array();
        let normal = (around(turn * uv.x) * ring).extend(height);
        (normal * radius, normal)
    };
    let what = "a sphere that is cut or scaled unevenly";
    curved([CORNERS * turn / TAU, rows], point, what, parameters, output)
}

fn disk(parameters: &Parameters, setting: &Setting, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    let radius = positive(parameters, "radius", 1.0)?;
    let inner = parameters.float("innerradius")?.unwrap_or(0.0).clamp(0.0, radius);
    let height = parameters.float("height")?.unwrap_or(0.0);
    let turn = sweep(parameters)?;
    if inner == 0.0 && turn >= TAU && !setting.textured {
        let size = DMat4::from_scale(DVec3::new(radius, radius, 1.0));
        let placed = setting.to_world * DMat4::from_translation(DVec3::Z * height) * size;
        return Ok(Draft::new(PluginClass::Shape, "disk", &parameters.place).with_transform("to_world", placed));
    }
    // pbrt's v falls outwards.
    let point = |uv: DVec2| {
        let ring = radius + (inner - radius) * uv.y;
        ((around(turn * uv.x) * ring).extend(height), DVec3::Z)
    };
    curved([CORNERS * turn / TAU, 1.0], point, "a disk that is cut or textured", parameters, output)
}

fn cylinder(parameters: &Parameters, setting: &Setting, output: &mut Output<'_>) -> Result<Draft, SceneError> {
    let radius = positive(parameters, "radius", 1.0)?;
    let [low, high] =
        [("zmin", -1.0), ("zmax", 1.0)].map(|(name, default)| parameters.float(name).map(|z| z.unwrap_or(default)));
    let (low, high) = (low?, high?);
    let (low, high) = (low.min(high), low.max(high));
    let turn = sweep(parameters)?;
    if turn >= TAU && keeps_shape(setting.to_world) && !setting.textured {
        return Ok(Draft::new(PluginClass::Shape, "cylinder", &parameters.place)
            .with_float("radius", radius)
            .with_point("p0", DVec3::Z * low)
            .with_point("p1", DVec3::Z * high));
    }
    let point = |uv: DVec2| {
        let across = around(turn * uv.x);
        ((across * radius).extend(low + (high - low) * uv.y), across.extend(0.0))
    };
    let what = "a cylinder that is cut, textured or scaled unevenly";
    curved([CORNERS * turn / TAU, 1.0], point, what, parameters, output)
}
