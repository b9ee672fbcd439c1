//! References by id become shared nodes.

use std::collections::HashMap;
use std::sync::Arc;

use super::DEPTH_LIMIT;
use super::draft::{Alias, Draft, Target};
use crate::scene::description::{Child, Node};
use crate::scene::error::{Location, SceneError, nearest_name};

/// The most plugins a scene may have when every reference counts as a copy. References to plugins that hold several
/// references multiply, so that a short file could otherwise stand for more plugins than a machine can visit.
const EXPANDED_LIMIT: u64 = 10_000_000;

/// The description tree for the drafts of a whole scene.
///
/// # Errors
/// On ids that are given twice or not at all, on references in a circle, and on a scene that references blow up.
pub(super) fn resolve(root: &Draft, aliases: &[Alias]) -> Result<Node, SceneError> {
    let mut resolver = Resolver { drafts: HashMap::new(), ids: Vec::new(), built: HashMap::new() };
    resolver.register(root)?;
    for alias in aliases {
        let draft = resolver.find(&alias.known, &alias.location)?;
        resolver.insert(&alias.other, draft, &alias.location)?;
    }
    Ok(resolver.node(root, 0)?.0)
}

struct Resolver<'a> {
    drafts: HashMap<&'a str, &'a Draft>,
    /// The ids in the order of the file, so that error messages do not depend on hashing.
    ids: Vec<&'a str>,
    /// Plugins with an id, by the draft's address; `None` while the plugin is being built.
    built: HashMap<*const Draft, Option<(Arc<Node>, u64)>>,
}

impl<'a> Resolver<'a> {
    fn register(&mut self, draft: &'a Draft) -> Result<(), SceneError> {
        if !draft.id.is_empty() {
            self.insert(&draft.id, draft, &draft.location)?;
        }
        for child in &draft.children {
            if let Target::Plugin(plugin) = &child.target {
                self.register(plugin)?;
            }
        }
        Ok(())
    }

    fn insert(&mut self, id: &'a str, draft: &'a Draft, location: &Location) -> Result<(), SceneError> {
        if let Some(first) = self.drafts.insert(id, draft) {
            let problem = format!("id \"{id}\" is already taken by the {} at {}", first.class.tag(), first.location);
            return Err(SceneError::new(location, problem, "give every plugin an id of its own"));
        }
        self.ids.push(id);
        Ok(())
    }

    fn find(&self, id: &str, location: &Location) -> Result<&'a Draft, SceneError> {
        self.drafts.get(id).copied().ok_or_else(|| {
            let remedy = if self.ids.is_empty() {
                "nothing in the scene has an id".to_owned()
            } else {
                nearest_name(id, &self.ids)
            };
            SceneError::new(location, format!("nothing has the id \"{id}\""), remedy)
        })
    }

    /// The plugin, and how many plugins it stands for when every reference counts as a copy.
    fn shared(&mut self, draft: &'a Draft, from: &Location, depth: usize) -> Result<(Arc<Node>, u64), SceneError> {
        match self.built.get(&std::ptr::from_ref(draft)) {
            Some(Some((node, count))) => return Ok((node.clone(), *count)),
            Some(None) => {
                let problem = format!("the references to \"{}\" go round in a circle", draft.id);
                return Err(SceneError::new(from, problem, "remove one of them"));
            }
            None => {}
        }
        if depth > DEPTH_LIMIT {
            let problem = format!("references and plugins nest more than {DEPTH_LIMIT} deep");
            return Err(SceneError::new(from, problem, "flatten the scene"));
        }
        self.built.insert(draft, None);
        let (node, count) = self.node(draft, depth)?;
        let node = Arc::new(node);
        self.built.insert(draft, Some((node.clone(), count)));
        Ok((node, count))
    }

    fn node(&mut self, draft: &'a Draft, depth: usize) -> Result<(Node, u64), SceneError> {
        let mut children = Vec::with_capacity(draft.children.len());
        let mut expanded = 1_u64;
        for child in &draft.children {
            let target = match &child.target {
                Target::Plugin(plugin) => plugin,
                Target::Reference(id) => self.find(id, &child.location)?,
            };
            let (node, count) = self.shared(target, &child.location, depth + 1)?;
            expanded = expanded.saturating_add(count);
            if expanded > EXPANDED_LIMIT {
                let problem = format!("references make this more than {EXPANDED_LIMIT} plugins");
                return Err(SceneError::new(&child.location, problem, "refer to fewer plugins that hold references"));
            }
            children.push(Child { name: child.name.clone(), node });
        }
        let node = Node {
            class: draft.class,
            plugin: draft.plugin.clone(),
            id: draft.id.clone(),
            name: draft.name.clone(),
            parameters: draft.parameters.clone(),
            children,
            location: draft.location.clone(),
        };
        Ok((node, expanded))
    }
}
