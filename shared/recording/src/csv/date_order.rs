//! Which of day, month and year stands first in dates that do not say it: the order in which the
//! times of the whole file go the shortest way.
//!
//! Read in a wrong order, a midnight is a step of a month or a year.

use super::{lines_of, taken};
use crate::intake::plan::{Clock, Plan, date_order_note};
use crate::intake::stamps::Order;
use crate::text::seen::Layout;
use std::path::Path;

/// Way that two orders may differ in and be as good [s].
const SAME_WAY_S: f64 = 1e-6;

/// Gives the dates of a plan the order that fits the whole file best, and notes which.
pub(super) fn settle(path: &Path, layout: &Layout, plan: &mut Plan) {
    let Clock::Stamps(parts) = &plan.clock else { return };
    let Some(taken_for) = parts.iter().find_map(|(_, form)| form.open_order()) else { return };
    let ways: Vec<(Order, f64)> =
        Order::OPEN.into_iter().filter_map(|order| Some((order, way_s(path, layout, plan, order)?))).collect();
    let Some(least) = ways.iter().map(|(_, way)| *way).min_by(f64::total_cmp) else { return };
    let mut best = ways.iter().filter(|(_, way)| *way <= least + SAME_WAY_S).map(|(order, _)| *order);
    let Some(order) = best.next() else { return };
    let others: Vec<&str> = best.map(Order::name).collect();
    let also = if others.is_empty() { String::new() } else { format!("; {} fits as well", others.join(" or ")) };
    plan.clock = clock_in(plan, order);
    let before = date_order_note(taken_for);
    plan.notes.retain(|note| *note != before);
    plan.notes.push(date_order_note(order) + &also);
}

fn clock_in(plan: &Plan, order: Order) -> Clock {
    match &plan.clock {
        Clock::Stamps(parts) => Clock::Stamps(parts.iter().map(|(at, form)| (*at, form.with_order(order))).collect()),
        clock => clock.clone(),
    }
}

/// Way that the times of the file go in an order of their dates; `None` where it does not fit.
fn way_s(path: &Path, layout: &Layout, plan: &Plan, order: Order) -> Option<f64> {
    let (clock, columns, notes) = (clock_in(plan, order), Vec::new(), Vec::new());
    let times = Plan { clock, columns, notes, second_clocks: Vec::new(), ..plan.clone() };
    let (file, mut lines) = lines_of(path).ok()?;
    taken(&file, &mut lines, layout, &times).ok().map(|(rows, _)| rows.way_s())
}
