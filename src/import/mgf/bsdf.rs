//! Materials of MGF as bsdfs.
//!
//! | MGF | here |
//! |---|---|
//! | `rd` alone | `diffuse` |
//! | `rs`, smooth | `conductor` that reflects `rs`; with `rd` a `blendbsdf` of both, which keeps both shares |
//! | `rs`, rough | `ward`, the model that MGF means, in the form that reflects what it should at grazing angles, too |
//! | `rs` with a real `ir` above 1 | `plastic`, `roughplastic` |
//! | `rs` with a complex `ir`, no `rd` | `conductor`, `roughconductor` |
//! | `ts` with a real `ir` above 1 | two-sided: `thindielectric`; one-sided: `dielectric`, `roughdielectric` |
//! | `td` | `difftrans`; a `blendbsdf` with what reflects |
//! | other `ts` | `mask`: that share passes straight through |
//! | `sides 2` | `twosided` |

use super::super::draft::Draft;
use super::color::GREY;
use super::material::{Component, Material};
use crate::scene::description::PluginClass;
use crate::scene::error::Location;
use crate::scene::notice::Notice;

/// Lumens per watt of equal-energy white light, as Radiance uses it: MGF's photometric units are divided by this.
pub(super) const LUMENS_PER_WATT: f64 = 179.0;

/// Writes down one material.
pub(super) struct Writer<'a> {
    /// What notices call the material.
    pub name: &'a str,
    pub location: &'a Location,
    pub notices: &'a mut Vec<Notice>,
}

impl Writer<'_> {
    /// The bsdf for all but the emission of `material`.
    pub(super) fn bsdf(&mut self, material: &Material) -> Draft {
        let mut material = *material;
        let albedo = material.albedo();
        if albedo > 1.0 + 1e-9 {
            self.approximated("the sum of shares above 1", "all of its shares are scaled down to a sum of 1");
            let parts = [&mut material.diffuse_reflection, &mut material.specular_reflection];
            parts.into_iter().for_each(|part| part.amount /= albedo);
            let parts = [&mut material.diffuse_transmission, &mut material.specular_transmission];
            parts.into_iter().for_each(|part| part.amount /= albedo);
        }
        if material.specular_transmission.amount > 0.0 && is_dielectric(&material) {
            return self.glass(&material);
        }
        if !material.two_sided {
            self.approximated("the invisible back", "it is black");
        }
        let straight = material.specular_transmission;
        if straight.amount == 0.0 {
            return self.scattering(&material);
        }
        if straight.roughness > 0.0 {
            self.approximated("the rough transmission", "that light passes straight through");
        }
        if straight.color != GREY {
            self.approximated("the colored transmission", "what passes straight through keeps its color");
        }
        // A mask shows its bsdf with the rest of the probability.
        let opacity = 1.0 - straight.amount.min(1.0);
        let parts = [&mut material.diffuse_reflection, &mut material.specular_reflection];
        for part in parts.into_iter().chain([&mut material.diffuse_transmission]) {
            part.amount = (part.amount / opacity.max(f64::MIN_POSITIVE)).min(1.0);
        }
        self.plugin("mask").with_float("opacity", opacity).with_child("", self.scattering(&material))
    }

    /// All but what passes straight through.
    fn scattering(&mut self, material: &Material) -> Draft {
        let mut material = *material;
        let through = material.diffuse_transmission;
        if through.amount == 0.0 {
            return self.sided(&material);
        }
        // Chosen with probabilities in proportion to their brightest channels, and divided by them, neither part
        // scatters more than it gets.
        let reflected = brightest(material.diffuse_reflection) + brightest(material.specular_reflection);
        let weight = brightest(through) / (brightest(through) + reflected);
        let transmittance = self.rgb(Component { amount: through.amount / weight, ..through });
        let sheet = self.plugin("difftrans").with_rgb("transmittance", transmittance);
        if reflected == 0.0 {
            return sheet;
        }
        let parts = [&mut material.diffuse_reflection, &mut material.specular_reflection];
        parts.into_iter().for_each(|part| part.amount /= 1.0 - weight);
        let front = self.sided(&material);
        self.plugin("blendbsdf").with_float("weight", weight).with_child("", front).with_child("", sheet)
    }

    fn sided(&mut self, material: &Material) -> Draft {
        let front = self.opaque(material);
        if material.two_sided { self.plugin("twosided").with_child("", front) } else { front }
    }

    fn opaque(&mut self, material: &Material) -> Draft {
        let diffuse = self.rgb(material.diffuse_reflection);
        let specular = self.rgb(material.specular_reflection);
        let roughness = material.specular_reflection.roughness;
        if material.specular_reflection.amount == 0.0 {
            return self.plugin("diffuse").with_rgb("reflectance", diffuse);
        }
        if is_dielectric(material) {
            return self.plastic(material, diffuse, specular);
        }
        if material.diffuse_reflection.amount == 0.0 && material.index[1] > 0.0 {
            return self.metal(material, specular);
        }
        if material.index != [1.0, 0.0] {
            self.approximated("the index of refraction", "the reflectance does not depend on the angle");
        }
        if roughness > 0.0 {
            return self.ward(roughness, diffuse, specular);
        }
        let mirror = self.plugin("conductor").with_text("material", "none");
        if material.diffuse_reflection.amount == 0.0 {
            return mirror.with_rgb("specular_reflectance", specular);
        }
        let shares = [material.diffuse_reflection, material.specular_reflection];
        let weight = brightest(shares[1]) / (brightest(shares[0]) + brightest(shares[1]));
        let [diffuse, specular] = [(shares[0], 1.0 - weight), (shares[1], weight)]
            .map(|(part, weight)| self.rgb(Component { amount: part.amount / weight, ..part }));
        let matte = self.plugin("diffuse").with_rgb("reflectance", diffuse);
        let mirror = mirror.with_rgb("specular_reflectance", specular);
        self.plugin("blendbsdf").with_float("weight", weight).with_child("", matte).with_child("", mirror)
    }

    fn ward(&mut self, roughness: f64, diffuse: [f64; 3], specular: [f64; 3]) -> Draft {
        let most = (0..3).map(|channel| diffuse[channel] + specular[channel]).fold(0.0, f64::max);
        if most > 1.01 {
            self.approximated("a color that cannot be so bright", "all of it is made darker");
        }
        // A little less than 1, so that the sum of the rounded shares is not more.
        let scale = if most > 1.0 - 1e-6 { (1.0 - 1e-6) / most } else { 1.0 };
        let [diffuse, specular] = [diffuse, specular].map(|rgb| rgb.map(|channel| channel * scale));
        let ward = self.plugin("ward").with_float("alpha_u", roughness).with_float("alpha_v", roughness);
        ward.with_rgb("diffuse_reflectance", diffuse).with_rgb("specular_reflectance", specular)
    }

    /// A coating over a diffuse base. `rs` and `rd` hold at normal incidence, where the coating reflects R(0).
    fn plastic(&mut self, material: &Material, diffuse: [f64; 3], specular: [f64; 3]) -> Draft {
        let index = material.index[0];
        let coating = normal_reflectance([index, 0.0]);
        let specular =
            self.cut(specular.map(|channel| channel / coating), "a reflectance above that of the index of refraction");
        // The base sees what the coating lets in, and all of what it lets out is counted in `diffuse_reflectance`.
        let base = diffuse.map(|channel| channel / (1.0 - coating));
        let base = self.cut(base, "a diffuse reflectance above what the coating lets out");
        let roughness = material.specular_reflection.roughness;
        let name = if roughness > 0.0 { "roughplastic" } else { "plastic" };
        let plastic = self.plugin(name).with_float("int_ior", index).with_float("ext_ior", 1.0);
        let plastic = plastic.with_rgb("diffuse_reflectance", base).with_rgb("specular_reflectance", specular);
        rough(plastic, roughness)
    }

    fn metal(&mut self, material: &Material, specular: [f64; 3]) -> Draft {
        let normal = normal_reflectance(material.index);
        let scale =
            self.cut(specular.map(|channel| channel / normal), "a reflectance above that of the index of refraction");
        let roughness = material.specular_reflection.roughness;
        let metal = self.plugin(if roughness > 0.0 { "roughconductor" } else { "conductor" });
        let metal = metal.with_rgb("eta", [material.index[0]; 3]).with_rgb("k", [material.index[1]; 3]);
        rough(metal.with_rgb("specular_reflectance", scale), roughness)
    }

    /// A pane or the surface of a solid. `rs` and `ts` hold at normal incidence; `ts` of a solid for 5 mm of it.
    fn glass(&mut self, material: &Material) -> Draft {
        let index = material.index[0];
        let surface = normal_reflectance(material.index);
        let roughness = material.specular_transmission.roughness;
        let [reflected, transmitted] = [material.specular_reflection, material.specular_transmission];
        let [reflected, transmitted] = [self.rgb(reflected), self.rgb(transmitted)];
        if material.diffuse_reflection.amount + material.diffuse_transmission.amount > 0.0 {
            self.approximated("the diffuse part of the glass", "it is clear");
        }
        let (name, reflectance, transmittance) = if material.two_sided {
            // Between two surfaces light goes back and forth: R' = 2R/(1 + R), T' = 1 - R'.
            let pane = 2.0 * surface / (1.0 + surface);
            if roughness > 0.0 {
                self.approximated("the roughness of the pane", "it is smooth");
            }
            ("thindielectric", reflected.map(|r| r / pane), transmitted.map(|t| t / (1.0 - pane)))
        } else {
            if transmitted.iter().any(|channel| channel.sqrt() / (1.0 - surface) < 0.99) {
                self.approximated("the absorption inside", "each surface absorbs as 2.5 mm of it do");
            }
            let name = if roughness > 0.0 { "roughdielectric" } else { "dielectric" };
            (name, reflected.map(|r| r / surface), transmitted.map(|t| t.sqrt() / (1.0 - surface)))
        };
        let reflectance = self.cut(reflectance, "a reflectance above that of the index of refraction");
        let transmittance = self.cut(transmittance, "a transmittance above that of the index of refraction");
        let glass = self.plugin(name).with_float("int_ior", index).with_float("ext_ior", 1.0);
        let glass = glass.with_rgb("specular_reflectance", reflectance);
        rough(glass.with_rgb("specular_transmittance", transmittance), if material.two_sided { 0.0 } else { roughness })
    }

    fn plugin(&self, name: &str) -> Draft {
        Draft::new(PluginClass::Bsdf, name, self.location)
    }

    fn approximated(&mut self, what: &str, instead: &str) {
        let notice = Notice::approximated(self.location, format!("{what} of material {}", self.name), instead);
        // Several components may say the same.
        if !self.notices.iter().rev().take(8).any(|known| *known == notice) {
            self.notices.push(notice);
        }
    }

    /// Reflectance or transmittance of a component.
    fn rgb(&mut self, component: Component) -> [f64; 3] {
        if component.amount == 0.0 {
            return [0.0; 3];
        }
        let (rgb, outside) = component.color.rgb(component.amount);
        if outside {
            self.approximated("a color outside of Rec. 709", "the nearest color of the same luminance takes its place");
        }
        self.cut(rgb, "a color that cannot be so bright")
    }

    /// At most 1, with a notice when that changes something.
    fn cut(&mut self, rgb: [f64; 3], what: &str) -> [f64; 3] {
        if rgb.iter().any(|channel| *channel > 1.01) {
            self.approximated(what, "what is too much is cut off");
        }
        rgb.map(|channel| channel.min(1.0))
    }
}

/// The roughness of a plugin's Beckmann facets, which is the root mean square slope; a smooth plugin has none.
fn rough(draft: Draft, roughness: f64) -> Draft {
    if roughness == 0.0 {
        return draft;
    }
    draft.with_text("distribution", "beckmann").with_float("alpha", roughness)
}

fn is_dielectric(material: &Material) -> bool {
    material.index[0] > 1.0 && material.index[1] == 0.0
}

/// The largest channel of a component.
fn brightest(component: Component) -> f64 {
    let (rgb, _) = component.color.rgb(component.amount);
    rgb.into_iter().fold(0.0, f64::max)
}

/// Fresnel's reflectance at normal incidence: ((n - 1)² + k²)/((n + 1)² + k²).
fn normal_reflectance([n, k]: [f64; 2]) -> f64 {
    ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k)
}
