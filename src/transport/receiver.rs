//! Where photons meet materials: a surface, as a path sees it, that reflects what photons bring.

use super::evenness::{Evenness, MeasuredDisc};
use super::photon_map::{GatherQuery, Gathered, PhotonLookup};
use super::shading;
use crate::math::{Rgb, Vec3, octahedral};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::material::{Lobes, Material, View};

/// A surface that receives photons.
#[derive(Clone, Copy)]
pub struct Receiver<'a> {
    hit: &'a Interaction,
    material: &'a Material,
    view: View,
    constant: Option<Rgb>,
    /// Photons on the other side of the surface count too.
    both_sides: bool,
}

/// Which photons count at a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Counting {
    /// R², m².
    pub radius_squared: f32,
    /// Photons with more segments do not count; 127 lets all count.
    pub most_segments: u32,
    /// Only photons that nothing but specular surfaces scattered count.
    pub caustics_only: bool,
}

impl<'a> Receiver<'a> {
    /// The surface that was hit, as `view` sees it.
    #[inline]
    pub fn new(scene: &'a Scene, hit: &'a Interaction, view: View) -> Self {
        let material = scene.material(hit.shape);
        let both_sides = scene.lobes_at(hit.shape).any(Lobes::TRANSMISSIVE);
        Self { hit, material, view, constant: material.constant_value(&view), both_sides }
    }

    /// How it is seen.
    #[inline]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The BSDF where it is the same for all photons that a query finds, sr⁻¹.
    #[inline]
    pub fn constant(&self) -> Option<Rgb> {
        self.constant
    }

    /// Where to look for photons.
    #[inline]
    pub fn query(&self, counting: Counting) -> GatherQuery {
        let Counting { radius_squared, most_segments, caustics_only } = counting;
        GatherQuery {
            position: self.hit.position,
            normal: shading::facing_normal(self.hit),
            radius_squared,
            most_segments,
            caustics_only,
            both_sides: self.both_sides,
        }
    }

    /// The local direction that the code of a photon stands for.
    #[inline(always)]
    pub fn incident(&self, direction: u32) -> Vec3 {
        self.hit.frame.to_local(octahedral::decode(direction))
    }

    /// The BSDF for light from a local direction, sr⁻¹. Photons carry their cosine already.
    #[inline(always)]
    pub fn value(&self, incident: Vec3) -> Rgb {
        match self.constant {
            Some(value) if incident.z * self.view.outgoing.z > 0.0 => value,
            Some(_) => Rgb::ZERO,
            None => self.material.evaluate(&self.view, incident),
        }
    }

    /// Shows the index of every photon in a disc to `visit`, with what it reflects of it: f_r·α, un-normalised, W·sr⁻¹.
    pub fn visit(&self, photons: &impl PhotonLookup, counting: Counting, mut visit: impl FnMut(usize, Rgb)) {
        photons.visit_disc(&self.query(counting), |index, _| {
            visit(index, self.value(self.incident(photons.direction(index))) * photons.flux(index));
        });
    }

    /// [`gather`](Self::gather) of the photons that `counts` wants, by their indices; `None` where it wants all.
    pub fn gather_some(
        &self,
        photons: &impl PhotonLookup,
        counting: Counting,
        mut counts: impl FnMut(usize) -> bool,
    ) -> Option<Gathered> {
        let mut gathered = Gathered::default();
        let mut leaves_out = false;
        photons.visit_disc(&self.query(counting), |index, is_inner| {
            if counts(index) {
                let flux = self.value(self.incident(photons.direction(index))) * photons.flux(index);
                gathered.add_photon(flux, is_inner);
            } else {
                leaves_out = true;
            }
        });
        leaves_out.then_some(gathered)
    }

    /// [`gather`](Self::gather) of the photons that `counts` wants, and how evenly lies what the camera sees of them, which is `throughput` times as much.
    pub fn gather_measured(
        &self,
        photons: &impl PhotonLookup,
        counting: Counting,
        throughput: Rgb,
        mut counts: impl FnMut(usize) -> bool,
    ) -> (Gathered, Evenness) {
        let query = self.query(counting);
        let (mut gathered, mut disc) = (Gathered::default(), MeasuredDisc::new(&query));
        photons.visit_disc(&query, |index, is_inner| {
            if counts(index) {
                let photon = photons.photon(index);
                let flux = self.value(self.incident(photon.direction)) * Rgb::from_array(photon.flux);
                gathered.add_photon(flux, is_inner);
                disc.add(Vec3::from_array(photon.position), throughput * flux);
            }
        });
        (gathered, disc.sums())
    }

    /// What it reflects of the photons in a disc: Σ f_r·α, un-normalised, W·sr⁻¹; and their number.
    #[inline]
    pub fn gather(&self, photons: &impl PhotonLookup, counting: Counting) -> Gathered {
        let query = self.query(counting);
        if let Some(value) = self.constant {
            let mut gathered = photons.gather(&query);
            gathered.flux *= value;
            gathered.inner_flux *= value;
            return gathered;
        }
        let mut gathered = Gathered::default();
        photons.visit_disc(&query, |index, is_inner| {
            let photon = photons.photon(index);
            let flux =
                self.material.evaluate(&self.view, self.incident(photon.direction)) * Rgb::from_array(photon.flux);
            gathered.add_photon(flux, is_inner);
        });
        gathered
    }
}
