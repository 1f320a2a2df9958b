//! Members of the leading model that free runs show not worth having.
//!
//! A member may be there beyond all doubt and take away nothing that a reader sees. Each is judged
//! against the leading model without it, by the same rule as all together are against the plant
//! alone, where noise does not explain the free run without it. The least one leaves first, since
//! another may take its part.

use super::compares::{Compares, Setting};
use crate::evidence::decide::Class;
use crate::evidence::hypothesis::Hypothesis;
use crate::evidence::model::key;
use crate::evidence::pool::Pool;

/// The leading model left, and the keys of the members that are seen and not worth adding; one
/// finding stays, which all together are judged by.
pub(super) fn worthy(setting: Setting<'_>, leader: usize) -> (usize, Vec<String>) {
    let (mut leader, mut left) = (leader, Vec::new());
    while let Some((without, name)) = least(setting, leader) {
        left.push(name);
        leader = without;
    }
    (leader, left)
}

fn is_finding(own: &Hypothesis) -> bool {
    matches!(own.class(), Class::Physics | Class::Sensor)
}

/// The model without the member that matters least, if that one is not worth adding.
fn least(setting: Setting<'_>, leader: usize) -> Option<(usize, String)> {
    let (_, pool, options) = setting;
    let model = &pool.entries[leader].model;
    if model.set.iter().filter(|own| is_finding(own)).count() < 2 {
        return None;
    }
    let compares = Compares::new(setting, leader);
    let of = |gone: usize| {
        let mut set = model.set.clone();
        let own = set.remove(gone);
        let without = place_of(pool, &key(&set, &model.problem))?;
        let compared = compares.beside(&pool.entries[without])?;
        let relevance = compared.relevance()?;
        (!compared.is_worth_adding(options.worth)).then(|| (relevance, without, own.key(&model.problem.plant)))
    };
    let members = (0..model.set.len()).filter(|gone| is_finding(&model.set[*gone]));
    let least = members.filter_map(of).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((least.1, least.2))
}

fn place_of(pool: &Pool, key: &str) -> Option<usize> {
    let is_it = |place: &usize| !pool.entries[*place].rejected && pool.entries[*place].model.key() == key;
    let all = (0..pool.entries.len()).filter(is_it);
    all.max_by(|a, b| pool.ahead(*a, *b).total_cmp(&0.0))
}
