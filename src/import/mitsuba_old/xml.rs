//! What only old scenes have in their XML: tags of other names, colors of other forms, and tags that are passed over.

use glam::DMat4;
use roxmltree::Node;

use super::super::mitsuba_xml::{Reader, Scope, parameter_path};
use super::super::transform;
use super::super::xml_element::{Attributes, File};
use super::super::xml_tags::{OTHER_TAGS, VALUE_TAGS, unknown_tag};
use super::super::{plugins, values};
use super::color;
use crate::scene::description::{Parameter, PluginClass, Value};
use crate::scene::error::{SceneError, closest_name};
use crate::scene::notice::Notice;

/// Tags that Mitsuba 0.6 knows and that have no counterpart, with what becomes of the scene without them.
const PASSED_OVER: [(&str, &str); 2] = [
    ("subsurface", "there is no subsurface scattering: the surface reflects as its bsdf does"),
    ("null", "it stands for nothing"),
];

/// The class that an old tag stands for.
pub(in super::super) fn class_of_tag(tag: &str) -> Option<PluginClass> {
    match tag {
        "camera" => Some(PluginClass::Sensor),
        "luminaire" => Some(PluginClass::Emitter),
        _ => plugins::class_of_tag(tag),
    }
}

impl Reader<'_> {
    /// Reads a tag that Mitsuba 3 does not have, or reads otherwise.
    pub(in super::super) fn old_child(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        scope: &mut Scope,
    ) -> Result<(), SceneError> {
        match element.tag_name().name() {
            tag if color::TAGS.contains(&tag) => self.color(file, element, scope),
            _ => self.pass_over(file, element, scope),
        }
    }

    fn color(&mut self, file: &File<'_>, element: Node<'_, '_>, scope: &mut Scope) -> Result<(), SceneError> {
        let tag = element.tag_name().name();
        let path = parameter_path(element, scope);
        let place = file.place(element, path.as_str());
        let attributes = self.attributes(file, element, &path, &["name"], color::attributes(tag))?;
        self.refuse_contents(file, element, &path)?;
        let bundle = self.bundle;
        let color = color::read(tag, &attributes, &place, |name| {
            self.register_file(name, &place)?;
            bundle.read(name, &place)
        })?;
        if color.from_spectrum {
            let subject = format!("the <{tag}> of \"{}\"", attributes.text("name"));
            let [red, green, blue] = color.rgb;
            let explanation = format!("rendering is in rgb, where its color is {red:.4}, {green:.4}, {blue:.4}");
            self.notices.push(Notice::approximated(&place, subject, explanation));
        }
        let (name, value) = (attributes.text("name").to_owned(), Value::Rgb(color.rgb));
        scope.draft.parameters.push(Parameter { name, value, location: place });
        Ok(())
    }

    /// Leaves out a tag that has no counterpart, or that Mitsuba does not know either: people take parts out of a scene
    /// by renaming their tags. What looks like a misspelling is an error as anywhere else.
    fn pass_over(&mut self, file: &File<'_>, element: Node<'_, '_>, scope: &mut Scope) -> Result<(), SceneError> {
        let tag = element.tag_name().name();
        let place = file.place(element, scope.draft.location.path.as_str());
        let known = PASSED_OVER.iter().find(|(known, _)| *known == tag);
        let tags = plugins::tags().chain(VALUE_TAGS).chain(OTHER_TAGS).chain(PASSED_OVER.iter().map(|(tag, _)| *tag));
        if known.is_none() && closest_name(tag, tags).is_some() {
            return Err(unknown_tag(&place, tag));
        }
        let reason = known.map_or("Mitsuba does not know this tag", |(_, reason)| reason);
        let shown: String = tag.chars().take(60).collect();
        self.notices.push(Notice::ignored(&place, format!("the <{shown}>"), reason));
        let ids = element.descendants().filter_map(|part| part.attribute("id"));
        self.old.passed_over.extend(ids.map(str::to_owned));
        Ok(())
    }

    /// A `<lookat>`, whose `up` may be missing, or the nine numbers of Mitsuba 0.2.
    pub(in super::super) fn old_look_at(
        &mut self,
        file: &File<'_>,
        element: Node<'_, '_>,
        path: &str,
    ) -> Result<DMat4, SceneError> {
        let place = file.place(element, path);
        let refused = |problem: String| SceneError::new(&place, format!("<lookat>: {problem}"), "change the numbers");
        let attributes: Attributes<'_>;
        let [origin, target, up] = if element.has_attribute("ox") {
            const NAMES: [[&str; 3]; 3] = [["ox", "oy", "oz"], ["tx", "ty", "tz"], ["ux", "uy", "uz"]];
            attributes = self.attributes(file, element, path, &NAMES[..2].concat(), &NAMES[2])?;
            NAMES.map(|names| {
                let given = names.map(|name| attributes.get(name));
                given.iter().all(Option::is_some).then(|| given.map(Option::unwrap_or_default).join(","))
            })
        } else {
            attributes = self.attributes(file, element, path, &["origin", "target"], &["up"])?;
            ["origin", "target", "up"].map(|name| attributes.get(name).map(str::to_owned))
        };
        let three = |text: &str| values::triple(text).map_err(|(problem, _)| refused(problem));
        let (origin, target) = (three(&origin.unwrap_or_default())?, three(&target.unwrap_or_default())?);
        let up = match up {
            Some(text) => three(&text)?,
            None => transform::any_up(origin, target),
        };
        let matrix = transform::look_at(origin, target, up).map_err(refused)?;
        let mirrored = element.has_attribute("ox");
        Ok(if mirrored { matrix * transform::scale([-1.0, 1.0, 1.0]) } else { matrix })
    }
}
