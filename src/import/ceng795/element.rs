//! Elements of a scene file: what stands inside of them, and where.

use roxmltree::Node;

use super::super::notices::Notices;
use super::super::values::shown;
use super::super::xml_element::File;
use crate::scene::error::{Location, SceneError, nearest_name};
use crate::scene::notice::Notice;

/// Tags that the format has and nothing here stands for, and what that means.
const UNSUPPORTED: [(&str, &str); 10] = [
    ("Textures", "surfaces have the reflectance of their materials"),
    ("Texture", "the surface has the reflectance of its material"),
    ("TexCoordData", "textures are not read"),
    ("NormalData", "the shading normals are those of the triangles"),
    ("Transformations", "it stands where its numbers say"),
    ("MotionBlur", "everything stands still"),
    ("BackgroundTexture", "the background is black"),
    ("SphericalDirectionalLight", "environment maps are not read from this format"),
    ("Tonemap", "EXR files are linear, and PNG files are not tone mapped"),
    ("SamplingMode", "the method chooses its samples"),
];

/// One element of the file.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    file: &'a File<'a>,
    node: Node<'a, 'a>,
}

impl<'a> Element<'a> {
    /// The element of `node` in `file`.
    pub(super) fn new(file: &'a File<'a>, node: Node<'a, 'a>) -> Self {
        Self { file, node }
    }

    /// Its tag.
    pub(super) fn tag(&self) -> &'a str {
        self.node.tag_name().name()
    }

    /// The value of an attribute.
    pub(super) fn attribute(&self, name: &str) -> Option<&'a str> {
        self.node.attribute(name).map(str::trim)
    }

    /// Whether an attribute says `true`.
    pub(super) fn flag(&self, name: &str) -> Result<bool, SceneError> {
        match self.attribute(name) {
            None | Some("false") => Ok(false),
            Some("true") => Ok(true),
            Some(other) => Err(self.error(format!("{name} is {}", shown(other)), "write true or false")),
        }
    }

    /// Where it stands, for example `scene.xml:7 (Scene/Materials/Material[2])`.
    pub(super) fn location(&self) -> Location {
        let mut steps: Vec<String> = self.node.ancestors().filter(Node::is_element).map(step).collect();
        steps.reverse();
        self.file.place(self.node, steps.join("/"))
    }

    /// An error about it.
    pub(super) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(&self.location(), problem, remedy)
    }

    /// All elements inside.
    pub(super) fn elements(&self) -> impl Iterator<Item = Element<'a>> + use<'a> {
        let file = self.file;
        self.node.children().filter(Node::is_element).map(move |node| Element { file, node })
    }

    /// All elements inside that have this tag.
    pub(super) fn all(&self, tag: &str) -> impl Iterator<Item = Element<'a>> {
        self.elements().filter(move |element| element.tag() == tag)
    }

    /// The one element inside that has this tag, if there is one.
    pub(super) fn child(&self, tag: &str) -> Result<Option<Element<'a>>, SceneError> {
        let mut found = self.all(tag);
        let first = found.next();
        match found.next() {
            Some(second) => Err(second.error(format!("<{tag}> is given twice"), "remove one of them")),
            None => Ok(first),
        }
    }

    /// The one element inside that has this tag.
    pub(super) fn required(&self, tag: &str) -> Result<Element<'a>, SceneError> {
        self.child(tag)?.ok_or_else(|| {
            let others: Vec<&str> = self.elements().map(|element| element.tag()).take(64).collect();
            let misspelled = crate::scene::error::closest_name(tag, others);
            let remedy = match misspelled {
                Some(other) => format!("write <{tag}> instead of <{}>", other.chars().take(60).collect::<String>()),
                None => format!("add <{tag}>"),
            };
            self.error(format!("<{}> has no <{tag}>", self.tag()), remedy)
        })
    }

    /// Its pieces of text: comments cut it.
    fn pieces(&self) -> impl Iterator<Item = (Node<'a, 'a>, &'a str)> + use<'a> {
        self.node.children().filter(Node::is_text).filter_map(|node| node.text().map(|text| (node, text)))
    }

    /// Its words.
    pub(super) fn words(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.pieces().flat_map(|(_, text)| text.split_whitespace())
    }

    /// Its text without the space round it, if that is one word.
    pub(super) fn word(&self) -> Result<&'a str, SceneError> {
        let mut words = self.words();
        match (words.next(), words.next()) {
            (Some(word), None) => Ok(word),
            _ => Err(self.error(format!("<{}> does not hold one word", self.tag()), "write one word or number")),
        }
    }

    /// Hands every word to `take`, which says what is wrong with it, if anything; the error has the word's own line.
    pub(super) fn each_word(
        &self,
        mut take: impl FnMut(&str) -> Result<(), (String, String)>,
    ) -> Result<(), SceneError> {
        for (node, text) in self.pieces() {
            for (index, line) in text.lines().enumerate() {
                line.split_whitespace().try_for_each(&mut take).map_err(|(problem, remedy)| {
                    let start = self.file.place(node, self.location().path);
                    SceneError::new(&Location { line: start.line + index as u32, ..start }, problem, remedy)
                })?;
            }
        }
        Ok(())
    }

    /// All of its numbers, which must be finite.
    pub(super) fn numbers(&self) -> Result<Vec<f64>, SceneError> {
        let mut numbers = Vec::new();
        self.each_word(|word| {
            let number = word.parse().ok().filter(|number: &f64| number.is_finite());
            let wrong = || (format!("{} is not a finite number", shown(word)), "write a number such as 0.5".to_owned());
            numbers.push(number.ok_or_else(wrong)?);
            Ok(())
        })?;
        Ok(numbers)
    }

    /// Exactly `N` numbers.
    pub(super) fn tuple<const N: usize>(&self) -> Result<[f64; N], SceneError> {
        let numbers = self.numbers()?;
        let count = numbers.len();
        <[f64; N]>::try_from(numbers)
            .map_err(|_| self.error(format!("<{}> has {count} numbers", self.tag()), format!("write {N} numbers")))
    }

    /// One number.
    pub(super) fn number(&self) -> Result<f64, SceneError> {
        self.tuple().map(|[number]| number)
    }

    /// A whole number of at least 0.
    pub(super) fn integer(&self) -> Result<i64, SceneError> {
        let word = self.word()?;
        word.parse().ok().filter(|number| *number >= 0).ok_or_else(|| {
            self.error(format!("{} is not a whole number of at least 0", shown(word)), "write one such as 8")
        })
    }

    /// Three numbers of at least 0.
    pub(super) fn color(&self) -> Result<[f64; 3], SceneError> {
        let color = self.tuple()?;
        match color.iter().all(|channel| *channel >= 0.0) {
            true => Ok(color),
            false => Err(self.error(format!("<{}> is below 0", self.tag()), "write numbers of at least 0")),
        }
    }

    /// The color in the element `tag` inside, black without one.
    pub(super) fn color_of(&self, tag: &str) -> Result<[f64; 3], SceneError> {
        self.child(tag)?.map_or(Ok([0.0; 3]), |element| element.color())
    }

    /// The number in the element `tag` inside, if there is one.
    pub(super) fn number_of(&self, tag: &str) -> Result<Option<f64>, SceneError> {
        self.child(tag)?.map(|element| element.number()).transpose()
    }

    /// Reports all elements and attributes of it that are none of these; `id` is always known.
    pub(super) fn report_unknown(&self, tags: &[&str], attributes: &[&str], notices: &mut Notices) {
        for element in self.elements().filter(|element| !tags.contains(&element.tag())) {
            let tag = element.tag();
            let unsupported = UNSUPPORTED.iter().find(|(name, _)| *name == tag);
            let explanation = unsupported.map_or_else(|| nearest_name(tag, tags), |(_, meaning)| (*meaning).to_owned());
            let subject = format!("<{}> in <{}>", short(tag), short(self.tag()));
            notices.add(Notice::ignored(&element.location(), subject, explanation));
        }
        for attribute in self.node.attributes().filter(|attribute| attribute.name() != "id") {
            if !attributes.contains(&attribute.name()) {
                let subject = format!("attribute \"{}\" of <{}>", short(attribute.name()), short(self.tag()));
                notices.add(Notice::ignored(&self.location(), subject, nearest_name(attribute.name(), attributes)));
            }
        }
    }
}

fn short(name: &str) -> String {
    name.chars().take(60).collect()
}

fn step(node: Node<'_, '_>) -> String {
    let tag = short(node.tag_name().name());
    match node.attribute("id") {
        Some(id) => format!("{tag}[{}]", short(id)),
        None => tag,
    }
}
