//! Cameras: `perspective`, `thinlens`, `orthographic`, `spherical`, `radiancemeter` (see `meter`) and `distant`.
//!
//! | parameter | meaning | unit, range | default |
//! |---|---|---|---|
//! | `fov` | angle of view along `fov_axis` | degrees, 0 to 180 | from `focal_length` |
//! | `focal_length` | of a 35 mm camera, instead of `fov` | `50mm` | `50mm` |
//! | `fov_axis` | `x`, `y`, `diagonal`, `smaller`, `larger` | – | `x` |
//! | `to_world` | the camera looks along +z, its left is +x, up is +y | – | identity |
//! | `near_clip`, `far_clip` | nearest and farthest depth that is seen | m | 0.01, 10000 |
//! | `principal_point_offset_x`, `principal_point_offset_y` | where the axis meets the film, from its middle towards the left and upwards | widths and heights of the film | 0 |
//! | `aperture_radius` | `thinlens`: radius of the lens | m, > 0 | – |
//! | `focus_distance` | `thinlens`: depth that is sharp | m, > 0 | `far_clip` |
//!
//! `orthographic` takes `to_world` and the clip depths: the film is 2 units of its own space wide, so that a scale in `to_world`
//! says how much it sees. All of its rays are parallel, so its densities are by area across them instead of by solid angle.
//!
//! `spherical` (Mitsuba 0.6, pbrt) takes the same and sees all around: rows are latitudes from up to down, columns longitudes. The middle of
//! the picture is forward, and its clip distances are along the rays.

mod distant;
mod matrices;
mod meter;
mod spherical;

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::error::{SceneError, nearest_name, shown_number};
use super::fields::Fields;
use super::geometry::Ray;
use super::geometry::transform::{ToWorld, to_single};
use super::unsupported::unknown_plugin;
use crate::math::{Vec2, warp};
pub use matrices::CameraMatrices;

/// How directions become places of the film.
#[derive(Clone, Copy, Debug)]
enum Projection {
    Perspective,
    Parallel,
    Spherical,
    /// Parallel rays through a disc, all in one pixel.
    Distant(distant::Target),
}

/// A camera, with or without a lens.
#[derive(Clone, Debug)]
pub struct Camera {
    position: Vec3,
    /// Unit axes: left, up, forward.
    axes: [Vec3; 3],
    /// Tangents of the half angles along x and y; of parallel rays half the film's width and height, m; of a sphere half its angles.
    half_extent: Vec2,
    projection: Projection,
    /// Where the axis meets the film, from its middle to the right and downwards, as shares of its sides.
    principal_point: Vec2,
    aperture_radius: f32,
    focus_distance: f32,
    near: f32,
    far: f32,
}

/// A point as the camera sees it.
#[derive(Clone, Copy, Debug)]
pub struct SeenByCamera {
    /// Place in the whole film; (0, 0) top left to (1, 1) bottom right is inside.
    pub film: Vec2,
    /// Unit direction from the point to the lens.
    pub direction: Vec3,
    /// What [`SeenByCamera::pdf`] is to be divided by for a density by area across the direction: the squared distance to the
    /// lens, m²; 1 for parallel rays.
    pub spread: f32,
    /// Distance to where camera rays start, m.
    pub visible_distance: f32,
    /// See [`Camera::pdf`].
    pub pdf: f32,
}

const CAMERAS: &[(&str, Projection)] = &[
    ("perspective", Projection::Perspective),
    ("thinlens", Projection::Perspective),
    ("orthographic", Projection::Parallel),
    ("spherical", Projection::Spherical),
];

/// Reads a camera of its own kind, for a whole film of so many pixels.
type ReadCamera = fn(&mut Fields<'_>, [u32; 2]) -> Result<Camera, SceneError>;

/// Reads a sensor's own parameters, for a whole film of `width` × `height` pixels; the film and sampler are read elsewhere.
pub fn read(fields: &mut Fields<'_>, [width, height]: [u32; 2]) -> Result<Camera, SceneError> {
    let plugin = fields.node().plugin.as_str();
    let of_one_pixel = match plugin {
        "radiancemeter" => Some(meter::read as ReadCamera),
        "distant" => Some(distant::read as ReadCamera),
        _ => None,
    };
    if let Some(read) = of_one_pixel {
        shutter(fields)?;
        return read(fields, [width, height]);
    }
    let Some((_, projection)) = CAMERAS.iter().find(|(name, _)| *name == plugin).copied() else {
        let known: Vec<&str> = CAMERAS.iter().map(|(name, _)| *name).collect();
        return Err(unknown_plugin(fields.node(), &known));
    };
    let to_world = ToWorld::read(fields)?;
    let (near, far) = clip(fields)?;
    let (half_extent, principal_point) = match projection {
        Projection::Perspective => (half_extent(fields, width, height)?, principal_point(fields)?),
        Projection::Parallel => (half_film(&to_world, f64::from(width) / f64::from(height)), Vec2::ZERO),
        Projection::Spherical => (Vec2::new(PI, 0.5 * PI), Vec2::ZERO),
        Projection::Distant(_) => (Vec2::ONE, Vec2::ZERO),
    };
    let (aperture_radius, focus_distance) = lens(fields, far)?;
    shutter(fields)?;
    let axis = |axis: DVec3| to_world.vector(axis).normalize().as_vec3();
    Ok(Camera {
        position: to_single(to_world.point(DVec3::ZERO), fields)?,
        axes: [axis(DVec3::X), axis(DVec3::Y), axis(DVec3::Z)],
        half_extent,
        projection,
        principal_point,
        aperture_radius,
        focus_distance,
        near,
        far,
    })
}

/// The times between which a sensor's shutter is open: `shutter_open` and `shutter_close`, both 0 by default. Nothing moves, and only
/// what belongs to a time of its own asks for them.
pub fn shutter(fields: &mut Fields<'_>) -> Result<[f64; 2], SceneError> {
    let [open, close] = [fields.float("shutter_open")?.unwrap_or(0.0), fields.float("shutter_close")?.unwrap_or(0.0)];
    if close < open {
        let problem =
            format!("\"shutter_close\" is {}, and \"shutter_open\" {}", shown_number(close), shown_number(open));
        return Err(fields.error("shutter_close", problem, "let the shutter close after it opens"));
    }
    Ok([open, close])
}

/// Half the width and height of what parallel rays see, m.
fn half_film(to_world: &ToWorld, aspect: f64) -> Vec2 {
    let [x, y] = [DVec3::X, DVec3::Y].map(|axis| to_world.vector(axis).length());
    Vec2::new(x as f32, (y / aspect) as f32)
}

fn principal_point(fields: &mut Fields<'_>) -> Result<Vec2, SceneError> {
    let mut offset = |name| Ok::<f32, SceneError>(fields.float(name)?.unwrap_or(0.0) as f32);
    Ok(-Vec2::new(offset("principal_point_offset_x")?, offset("principal_point_offset_y")?))
}

fn positive(fields: &mut Fields<'_>, name: &'static str) -> Result<Option<f32>, SceneError> {
    match fields.float(name)? {
        Some(number) if number <= 0.0 => {
            Err(fields.error(name, format!("\"{name}\" is {}", shown_number(number)), "give a number above 0"))
        }
        number => Ok(number.map(|number| number as f32)),
    }
}

fn clip(fields: &mut Fields<'_>) -> Result<(f32, f32), SceneError> {
    let near = positive(fields, "near_clip")?.unwrap_or(0.01);
    let far = positive(fields, "far_clip")?.unwrap_or(10_000.0);
    if near < far {
        return Ok((near, far));
    }
    Err(fields.error(
        "near_clip",
        format!("nothing lies between {} and {} m", shown_number(near), shown_number(far)),
        "set near_clip below far_clip",
    ))
}

fn lens(fields: &mut Fields<'_>, far: f32) -> Result<(f32, f32), SceneError> {
    if fields.node().plugin != "thinlens" {
        fields.ignore(&["focus_distance"]);
        return Ok((0.0, 1.0));
    }
    let focus_distance = positive(fields, "focus_distance")?.unwrap_or(far);
    match positive(fields, "aperture_radius")? {
        Some(radius) => Ok((radius, focus_distance)),
        None => Err(SceneError::new(fields.location(), "a thinlens has no \"aperture_radius\"", "give it in metres")),
    }
}

/// Tangents of the half angles of view along x and y.
///
/// # Errors
/// Angles out of range, and both `fov` and `focal_length`.
pub fn half_extent(fields: &mut Fields<'_>, width: u32, height: u32) -> Result<Vec2, SceneError> {
    let aspect = f64::from(width) / f64::from(height);
    let Some(fov) = fields.float("fov")? else { return focal_length(fields, aspect) };
    if !(fov > 0.0 && fov < 180.0) {
        return Err(fields.error(
            "fov",
            format!("\"fov\" is {} degrees", shown_number(fov)),
            "give an angle between 0 and 180 degrees",
        ));
    }
    if fields.has("focal_length") {
        return Err(fields.error("fov", "a sensor has both \"fov\" and \"focal_length\"", "give one of them"));
    }
    let tangent = libm::tan(0.5 * fov.to_radians());
    let x = match fields.string("fov_axis")?.unwrap_or("x") {
        "x" => tangent,
        "y" => tangent * aspect,
        "smaller" => tangent * aspect.max(1.0),
        "larger" => tangent * aspect.min(1.0),
        "diagonal" => tangent * aspect / (1.0 + aspect * aspect).sqrt(),
        other => {
            let remedy = nearest_name(other, &["x", "y", "diagonal", "smaller", "larger"]);
            return Err(fields.error("fov_axis", format!("there is no fov_axis \"{other}\""), remedy));
        }
    };
    Ok(Vec2::new(x as f32, (x / aspect) as f32))
}

fn focal_length(fields: &mut Fields<'_>, aspect: f64) -> Result<Vec2, SceneError> {
    let text = fields.string("focal_length")?.unwrap_or("50mm");
    fields.ignore(&["fov_axis"]);
    match text.trim_end_matches("mm").trim().parse::<f64>() {
        Ok(length) if length > 0.0 && length.is_finite() => {
            // Half the diagonal of a 36 × 24 mm film.
            let tangent = 0.5 * f64::sqrt(36.0 * 36.0 + 24.0 * 24.0) / length;
            let x = tangent * aspect / (1.0 + aspect * aspect).sqrt();
            Ok(Vec2::new(x as f32, (x / aspect) as f32))
        }
        _ => Err(fields.error("focal_length", format!("\"{text}\" is no focal length"), "write for example 50mm")),
    }
}

/// How far from the axis a unit vector reaches that reaches `along` it.
fn across(along: f32) -> f32 {
    (1.0 - along * along).max(0.0).sqrt()
}

impl Camera {
    /// The ray through a point of the film, (0, 0) top left to (1, 1) bottom right, and a lens sample in [0, 1)².
    #[inline]
    pub fn ray(&self, picture: Vec2, lens: [f32; 2]) -> Ray {
        let picture = picture - self.principal_point;
        let x = (1.0 - 2.0 * picture.x) * self.half_extent.x;
        let y = (1.0 - 2.0 * picture.y) * self.half_extent.y;
        let [left, up, forward] = self.axes;
        match self.projection {
            Projection::Perspective => {}
            Projection::Parallel => {
                let origin = self.position + left * x + up * y + forward * self.near;
                return Ray { origin, direction: forward, length: self.far - self.near };
            }
            Projection::Spherical => {
                let ((sine, cosine), (upwards, level)) = (libm::sincosf(x), libm::sincosf(y));
                let direction = (left * (sine * level) + up * upwards + forward * (cosine * level)).normalize();
                let origin = self.position + direction * self.near;
                return Ray { origin, direction, length: self.far - self.near };
            }
            Projection::Distant(_) => {
                let point = warp::disc(lens) * self.aperture_radius;
                return Ray::new(self.position + left * point.x + up * point.y, forward);
            }
        }
        let through = left * x + up * y + forward;
        let (start, direction) = if self.aperture_radius > 0.0 {
            let point = warp::disc(lens) * self.aperture_radius;
            let start = left * point.x + up * point.y;
            (start, (through * self.focus_distance - start).normalize())
        } else {
            (Vec3::ZERO, through.normalize())
        };
        // Clip distances are depths along the axis.
        let per_depth = 1.0 / direction.dot(forward);
        let origin = self.position + start + direction * (self.near * per_depth);
        Ray { origin, direction, length: (self.far - self.near) * per_depth }
    }

    /// The density of [`Camera::ray`] for a film point uniform over the whole film: of directions by solid angle, for all points
    /// of the lens the same; of parallel rays by area across them.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match self.projection {
            Projection::Perspective => {}
            Projection::Parallel => return 1.0 / (4.0 * self.half_extent.x * self.half_extent.y),
            Projection::Distant(_) => return 1.0 / (PI * self.aperture_radius * self.aperture_radius),
            // Circles of latitude are as wide on the film as the equator.
            Projection::Spherical => return 1.0 / (2.0 * PI * PI * across(direction.dot(self.axes[1]))),
        }
        let cosine = direction.dot(self.axes[2]);
        1.0 / (4.0 * self.half_extent.x * self.half_extent.y * cosine * cosine * cosine)
    }

    /// How far along `direction` rays start, m.
    #[inline]
    fn near_distance(&self, direction: Vec3) -> f32 {
        match self.projection {
            Projection::Spherical => self.near,
            _ => self.near / direction.dot(self.axes[2]),
        }
    }

    /// What [`Camera::pdf`] is to be divided by for the density by area across `direction` at `distance` along a ray of the
    /// camera: see [`SeenByCamera::spread`].
    #[inline]
    pub fn spread(&self, direction: Vec3, distance: f32) -> f32 {
        if matches!(self.projection, Projection::Parallel | Projection::Distant(_)) {
            return 1.0;
        }
        let distance = distance + self.near_distance(direction);
        distance * distance
    }

    /// Where the film sees `point` from a place of the lens; `None` behind the camera and beyond its clip distances.
    #[inline]
    pub fn look_at(&self, point: Vec3, lens: [f32; 2]) -> Option<SeenByCamera> {
        match self.projection {
            Projection::Spherical => return self.look_around(point),
            Projection::Distant(_) => return self.look_from_afar(point, lens),
            Projection::Perspective | Projection::Parallel => {}
        }
        let [left, up, forward] = self.axes;
        let start = warp::disc(lens) * self.aperture_radius;
        let from_lens = point - (self.position + left * start.x + up * start.y);
        let depth = from_lens.dot(forward);
        if !(depth > self.near && depth < self.far) {
            return None;
        }
        let middle = self.principal_point + 0.5;
        if matches!(self.projection, Projection::Parallel) {
            let film = Vec2::new(from_lens.dot(left), from_lens.dot(up)) / self.half_extent;
            let (direction, visible_distance) = (-forward, depth - self.near);
            let pdf = self.pdf(forward);
            return Some(SeenByCamera { film: middle - film * 0.5, direction, spread: 1.0, visible_distance, pdf });
        }
        // Lens and point span a line that meets the plane of focus where the whole film is sharp.
        let sharp = |offset: f32, lens: f32| offset / depth + lens / self.focus_distance;
        let x = sharp(from_lens.dot(left), start.x) / self.half_extent.x;
        let y = sharp(from_lens.dot(up), start.y) / self.half_extent.y;
        let distance = from_lens.length();
        let direction = from_lens / distance;
        Some(SeenByCamera {
            film: Vec2::new(middle.x - 0.5 * x, middle.y - 0.5 * y),
            direction: -direction,
            spread: distance * distance,
            visible_distance: distance - self.near_distance(direction),
            pdf: self.pdf(direction),
        })
    }

    /// How far a place of the film is repeated to its left and right, as shares of its width: a picture of all around begins again.
    #[inline]
    pub fn repeats(&self) -> &'static [f32] {
        match self.projection {
            Projection::Spherical => &[0.0, -1.0, 1.0],
            _ => &[0.0],
        }
    }

    /// Whether it has a lens, so that only what lies at one depth is sharp.
    pub fn has_lens(&self) -> bool {
        self.aperture_radius > 0.0 && !self.is_distant()
    }

    /// Whether it stands outside of the scene and sees all of it, or a point, in one pixel.
    pub fn is_distant(&self) -> bool {
        matches!(self.projection, Projection::Distant(_))
    }

    /// Where it stands, m.
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// The distance of what it sees at `point`, m: from where it stands, or along parallel rays.
    #[inline]
    pub fn distance_to(&self, point: Vec3) -> f32 {
        match self.projection {
            Projection::Parallel | Projection::Distant(_) => (point - self.position).dot(self.axes[2]),
            _ => point.distance(self.position),
        }
    }

    /// Radius of the footprint of a pixel at `distance`, m, in a whole film `width` pixels wide.
    pub fn pixel_footprint(&self, distance: f32, width: u32) -> f32 {
        match self.projection {
            Projection::Parallel => self.half_extent.x / width as f32,
            Projection::Distant(_) => self.aperture_radius,
            _ => distance * self.half_extent.x / width as f32,
        }
    }
}
