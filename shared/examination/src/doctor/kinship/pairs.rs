//! Which channels are related, by their units and names.

use super::super::quantity::{self, Quantity};
use channels::Channel;
use std::collections::HashMap;

/// What of a channel says to which others it is related.
struct Described {
    quantity: Quantity,
    place: Vec<String>,
    /// No other channel has this kind and order.
    is_only: bool,
}

/// Pairs of channels whose units and names say that the second is a derivative of the first, or the
/// same under another clock, and the order of the derivative.
///
/// Looks at channels of one place together, and at those that are the only ones of their kind: no
/// longer than the pairs are many, but where many channels have no place.
pub(super) fn related_by_name(channels: &[&Channel]) -> Vec<(usize, usize, usize)> {
    let described = described(channels);
    let mut of_place: HashMap<&[String], Vec<usize>> = HashMap::new();
    let mut only = Vec::new();
    for (at, of) in described.iter().enumerate().filter_map(|(at, of)| Some((at, of.as_ref()?))) {
        of_place.entry(&of.place).or_default().push(at);
        only.extend(Some(at).filter(|_| of.is_only));
    }
    let mut pairs = Vec::new();
    for (i, a) in described.iter().enumerate().filter_map(|(at, of)| Some((at, of.as_ref()?))) {
        let mut others = of_place[a.place.as_slice()].clone();
        others.extend(only.iter().filter(|_| a.is_only));
        others.sort_unstable();
        others.dedup();
        let order = |j: usize| order_between((a, channels[i]), (described[j].as_ref()?, channels[j]));
        let related = others.into_iter().filter(|j| *j != i).filter_map(|j| Some((i, j, order(j)?)));
        pairs.extend(related.filter(|(i, j, order)| *order > 0 || i < j));
    }
    pairs
}

fn described(channels: &[&Channel]) -> Vec<Option<Described>> {
    let quantities: Vec<Option<Quantity>> = channels.iter().map(|channel| quantity::of_channel(channel)).collect();
    let alike = |q: &Quantity, of: &Quantity| (q.kind, q.order) == (of.kind, of.order);
    // there are few kinds and orders, however many channels
    let mut kinds: Vec<(Quantity, usize)> = Vec::new();
    for quantity in quantities.iter().flatten() {
        match kinds.iter_mut().find(|(of, _)| alike(of, quantity)) {
            Some((_, count)) => *count += 1,
            None => kinds.push((*quantity, 1)),
        }
    }
    let is_only = |quantity: &Quantity| kinds.iter().any(|(of, count)| *count == 1 && alike(of, quantity));
    channels
        .iter()
        .zip(&quantities)
        .map(|(channel, quantity)| {
            let quantity = (*quantity)?;
            Some(Described { quantity, place: quantity::place(&channel.name), is_only: is_only(&quantity) })
        })
        .collect()
}

fn order_between((a, own): (&Described, &Channel), (b, other): (&Described, &Channel)) -> Option<usize> {
    let (qa, qb) = (a.quantity, b.quantity);
    if qa.kind != qb.kind || qa.kind == quantity::Kind::Other || qb.order < qa.order || qa.drives() {
        return None;
    }
    let same_place = a.place == b.place;
    if qa.order == qb.order {
        return (same_place && !own.same_clock(other)).then_some(0);
    }
    (same_place || (a.is_only && b.is_only)).then_some(qb.order - qa.order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use channels::Role;

    fn channel(name: String, unit: &str) -> Channel {
        Channel { name, unit: unit.into(), time_s: Vec::new(), value: Vec::new(), role: Role::Output }
    }

    #[test]
    fn of_thousands_of_channels_those_of_one_place_are_related() {
        let mut all: Vec<Channel> = Vec::new();
        for k in 0..2500 {
            all.push(channel(format!("angle_{k}"), "rad"));
            all.push(channel(format!("rate_{k}"), "rad/s"));
        }
        all.push(channel("left force".into(), "m"));
        all.push(channel("right".into(), "m/s"));
        let pairs = related_by_name(&all.iter().collect::<Vec<_>>());
        let expected = (0..2500).map(|k| (2 * k, 2 * k + 1, 1)).chain([(5000, 5001, 1)]);
        assert_eq!(pairs, expected.collect::<Vec<_>>());
    }
}
