//! Parameters of `photon_map` that contradict each other, or leave one without effect: refused with what would be right.

use super::parameters::{DEFAULT_COARSEST, DEFAULT_FINEST, DirectMode, Parameters, ShownPart};
use super::storage::Storage;
use crate::method::Contradiction;
use crate::method::parameter_values::{Auto, PhotonEmission, Switchable};
use crate::transport::caustic_splitting::Splitting;
use crate::transport::neighbor_choice::NeighborChoice;

/// The segments of the shortest path with a caustic: light, specular surface, what it lights, camera.
const SHORTEST_CAUSTIC: i64 = 3;

impl Parameters {
    /// The first contradiction, if there is any.
    pub(super) fn first_contradiction(&self) -> Option<Contradiction> {
        self.of_maps()
            .or_else(|| self.of_look_ups())
            .or_else(|| self.of_direct_light())
            .or_else(|| self.of_cache())
            .or_else(|| self.of_splitting())
            .or_else(|| self.of_chains())
    }

    /// How parameters that say which pixels look at which maps contradict each other, if they do.
    fn of_maps(&self) -> Option<Contradiction> {
        let maps = self.maps.get();
        match self.photons_per_pass {
            Auto::Value(photons) if photons.get() < maps => refused(
                format!("\"maps\" is {maps}, and \"photons_per_pass\" has {} for all of them", photons.get()),
                "give each map a photon at least",
            ),
            _ if self.hierarchy.get() == 0 => self.without_hierarchy(),
            _ => self.with_hierarchy(),
        }
    }

    /// What only a hierarchy has must not be given without one.
    fn without_hierarchy(&self) -> Option<Contradiction> {
        let given = [
            ("coarsest_samples", self.coarsest_samples != DEFAULT_COARSEST),
            ("finest_samples", self.finest_samples != DEFAULT_FINEST),
            ("localization", self.localization.get() > 0),
            ("show", self.show == ShownPart::Localized),
        ];
        let (name, _) = given.into_iter().find(|(_, is_given)| *is_given)?;
        let remedy = "give \"hierarchy\" a number of levels, for example 8";
        refused(format!("\"{name}\" is about levels of sampling, and \"hierarchy\" is 0, so there are none"), remedy)
    }

    fn with_hierarchy(&self) -> Option<Contradiction> {
        let (coarsest, finest) = (self.coarsest_samples.get(), self.finest_samples.get());
        if self.skipping.get() > 1 {
            let problem = "\"hierarchy\" and \"skipping\" both say which maps a pixel looks at";
            return refused(problem.to_owned(), "leave one of them out");
        }
        if finest > coarsest {
            let problem = format!("\"finest_samples\" is {finest}, and \"coarsest_samples\" is {coarsest}");
            return refused(problem, "finer levels have at most as many samples as coarser ones");
        }
        if self.localization.get() > 0 && finest == coarsest {
            let problem =
                format!("\"localization\" is given, and all levels have {finest} samples, so no pixel lacks any");
            return refused(
                problem,
                "give \"finest_samples\" fewer than \"coarsest_samples\", or leave \"localization\" out",
            );
        }
        if self.show == ShownPart::Localized && self.localization.get() == 0 {
            let problem = "\"show\" is \"localized\", and \"localization\" is 0, so no pixel is";
            return refused(problem.to_owned(), "give \"localization\" a contrast, for example 25");
        }
        None
    }

    /// A parameter of look-ups that others leave without any effect.
    fn of_look_ups(&self) -> Option<Contradiction> {
        let (share, neighbors) = (self.fewest_photons.get(), self.caustic_neighbors.get());
        if share > 0 && self.fewest_hundredths() <= 100 {
            let problem = format!(
                "\"fewest_photons\" is {share} % of \"caustic_neighbors\" {neighbors}, and what finds less than one photon is black already"
            );
            return refused(problem, &format!("give more than {}, or 0", 100 / neighbors));
        }
        let most = self.neighbors.get().max(self.caustic_neighbors.get());
        match self.neighbor_choice {
            NeighborChoice::Fixed => None,
            _ if most > 2 => None,
            _ => refused(
                "\"neighbor_choice\" has nothing to choose from where \"neighbors\" and \"caustic_neighbors\" are 2"
                    .to_owned(),
                "give more neighbors, or \"fixed\"",
            ),
        }
    }

    /// A parameter that was given and means nothing for how direct light is found.
    fn of_direct_light(&self) -> Option<Contradiction> {
        let (direct, usual) = (self.direct, Self::default());
        let looks_up = direct != DirectMode::Sample;
        let (name, users) = if self.direct_samples != usual.direct_samples && direct == DirectMode::Photons {
            ("direct_samples", "\"sample\", \"shadow_photons\" or \"photon_direct\"")
        } else if self.direct_neighbors != usual.direct_neighbors && !looks_up {
            ("direct_neighbors", "\"photons\", \"shadow_photons\" or \"photon_direct\"")
        } else if self.direct_reuse != usual.direct_reuse && direct != DirectMode::PhotonDirect {
            ("direct_reuse", "\"photon_direct\"")
        } else if self.maps.get() > 1 && looks_up {
            ("maps", "\"sample\", since direct light is looked up in one map")
        } else {
            return None;
        };
        let problem = format!("\"{name}\" means nothing with this \"direct\"");
        refused(problem, &format!("leave it out, or let \"direct\" be {users}"))
    }

    /// How parameters of the irradiance cache contradict others, if they do.
    fn of_cache(&self) -> Option<Contradiction> {
        match (self.cache_error, self.cache_rays) {
            (Switchable::Off, Auto::Value(rays)) => refused(
                format!("\"cache_rays\" is {}, and without \"cache_error\" there is no irradiance cache", rays.get()),
                "give \"cache_error\" too, for example 0.2",
            ),
            (Switchable::On(error), _) if self.final_gather.get() == 0 => refused(
                format!("\"cache_error\" is {}, and with \"final_gather\" 0 no rays gather what it keeps", error.get()),
                "give \"final_gather\" at least 1",
            ),
            (Switchable::On(_), _) if self.skipping.get() > 1 || self.hierarchy.get() > 0 => refused(
                "\"cache_error\" needs one set of maps that all pixels look at".to_owned(),
                "leave \"skipping\" and \"hierarchy\" out",
            ),
            _ => None,
        }
    }

    /// How photons of chains contradict other parameters, if they do.
    fn of_chains(&self) -> Option<Contradiction> {
        if self.emission != PhotonEmission::Metropolis {
            return None;
        }
        let name = if self.storage != Storage::All {
            "storage"
        } else if self.caustic_splitting.get() > 1 {
            "caustic_splitting"
        } else {
            return None;
        };
        refused(
            format!("\"{name}\" chooses among photons that \"emission\": \"metropolis\" has chosen already"),
            "leave one of them out",
        )
    }

    /// How parameters of caustic splitting contradict others, if they do.
    fn of_splitting(&self) -> Option<Contradiction> {
        let factor = self.caustic_splitting.get();
        if factor == 1 {
            return match self.splitting {
                Splitting::Brute => None,
                _ => refused(
                    "\"splitting\" is given, but \"caustic_splitting\" is 1: nothing is split".to_owned(),
                    "give \"caustic_splitting\" of at least 2, for example 20",
                ),
            };
        }
        let depth = self.max_depth.get();
        if (1..SHORTEST_CAUSTIC).contains(&depth) {
            return refused(
                format!("\"caustic_splitting\" is {factor}, but paths of {depth} segments have no caustic"),
                &format!("give \"max_depth\" of at least {SHORTEST_CAUSTIC}, or \"caustic_splitting\" 1"),
            );
        }
        // A number by now, whatever was given.
        let Auto::Value(photons) = self.photons_per_pass else { return None };
        // Paths are numbered in 32 bits.
        let most = u32::MAX / photons.get();
        if factor > most {
            return refused(
                format!("{} photons in \"caustic_splitting\" {factor} are too many for a pass", photons.get()),
                &format!("give \"caustic_splitting\" of at most {most}"),
            );
        }
        None
    }
}

fn refused(problem: String, remedy: &str) -> Option<Contradiction> {
    Some(Contradiction { problem, remedy: remedy.to_owned() })
}
