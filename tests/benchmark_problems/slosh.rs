//! Slices of the slosh campaigns: every method beside the bound, burst and stroke, the plane,
//! spring or pendulum.

use crate::campaigns::{SEED, honest, methods, spread};
use crate::claims::{Claim, demand};
use bench::campaign::{Benchmark, Campaign};
use bench::report::MethodReport;
use bench::slosh::global::RandomTanks;
use bench::slosh::planar::Planar;
use bench::slosh::tank_model::TankModelChoice;
use bench::slosh::{self, Concealed, Slosh, suspension, trend};
use bench::slosh_suspension::SuspensionKind;
use physics::slosh_likelihood::SloshUnknowns;

fn efficiency(report: &MethodReport, limit: f64) -> Vec<Claim> {
    let say = |name: &str| format!("{} {name} RMSE/CRLB", report.name);
    report.parameters.iter().map(|row| Claim::at_most(say(row.name), row.rmse_over_crlb, limit)).collect()
}

#[test]
fn repaired_instruments_and_the_filter_bank_attain_the_bound_on_the_seed_sine() {
    let (bp2, records) = (Slosh::bp2(), 20);
    let reports = methods(&bp2, &bp2, records);
    let mut claims = Vec::new();
    for place in [slosh::REFINED, slosh::ONE_PASS, slosh::TWO_PASSES] {
        claims.extend(honest(&reports[place], records));
        claims.extend(efficiency(&reports[place], 1.1 * (1.0 + spread(records))));
    }
    demand(&claims);
}

#[test]
fn the_published_estimators_fail_on_the_damping_and_worse_so_with_more_data() {
    let campaign = Campaign::new(30, SEED);
    let at = |duration_s| trend::medians(&Slosh::bp2(), &campaign, duration_s).expect("exciting");
    let (short, long) = (at(500.0), at(1000.0));
    for (method, name) in ["tls-paper", "iv-paper"].into_iter().enumerate() {
        // 200 records of an independent study: 350 % and 958 %, 347 % and 2731 %. The claim is the
        // kind of failure.
        let (c_500, c_1000) = (short[method][2], long[method][2]);
        demand(&[
            Claim::within(format!("{name} median c_s % at 500 s"), c_500, 100.0, f64::INFINITY),
            Claim::within(format!("{name} growth to 1000 s"), c_1000 / c_500, 1.5, f64::INFINITY),
        ]);
    }
    let bounds = (short[2][2], long[2][2]);
    demand(&[Claim::within("bound of c_s shrinks", bounds.0 / bounds.1, 2.0, 2.4)]); // 2.25 / 1.02 %
}

#[test]
fn a_burst_with_coasting_attains_its_bound_with_start_bias_and_scale_unknown() {
    let (burst, records) = (Slosh::burst(), 20);
    let report = &methods(&burst, &burst, records)[slosh::FLIGHT];
    let mut claims = honest(report, records);
    claims.extend(efficiency(report, 1.0 + spread(records)));
    demand(&claims);
}

#[test]
fn half_a_metre_of_stroke_attains_its_bound() {
    let (stroke, records) = (Slosh::stroke(0.0013 / 0.008), 20);
    assert!((stroke.stroke_m() - 0.5).abs() < 1e-9); // linear in the amplitude
    let report = &methods(&stroke, &stroke, records)[slosh::FLIGHT];
    let mut claims = honest(report, records);
    claims.extend(efficiency(report, 1.0 + spread(records)));
    demand(&claims);
}

#[test]
fn seven_numbers_in_the_plane_are_found_from_the_scan_alone() {
    let planar = Planar::bp2();
    let answers = Campaign::new(4, SEED).run(&planar, &|| ());
    for answer in answers.iter().flatten() {
        // χ² with seven degrees beyond 29.9: once in 10⁴.
        demand(&[Claim::at_most("NEES of seven", answer.nees, 29.9)]);
    }
}

#[test]
fn a_pendulum_is_told_from_a_spring_by_three_levels_of_thrust() {
    for truth in [TankModelChoice::pendulum(), TankModelChoice::spring()] {
        let campaign = Campaign::new(2, SEED);
        let judged = suspension::verdicts(&truth, &campaign, &|| ()).expect("both models fit");
        assert_eq!(judged.right, campaign.trials, "{}: {judged:?}", truth.name());
        demand(&[
            Claim::within("z of the right model, least", judged.z_right.low, -4.0, 4.0),
            Claim::within("z of the right model, greatest", judged.z_right.high, -4.0, 4.0),
            Claim::within("z of the wrong model", judged.z_wrong.low, 50.0, f64::INFINITY),
            Claim::within("mass, least error in sigmas", judged.mass_sigmas.low, -3.0, 3.0),
            Claim::within("mass, greatest error in sigmas", judged.mass_sigmas.high, -3.0, 3.0),
        ]);
        if truth.truth == SuspensionKind::Pendulum {
            demand(&[
                Claim::within("least error of L %", judged.error_percent.low, -0.2, 0.2),
                Claim::within("greatest error of L %", judged.error_percent.high, -0.2, 0.2),
            ]);
        }
    }
}

#[test]
fn random_tanks_are_found_from_the_scan_alone() {
    let tanks = RandomTanks::new();
    let reports = methods(&tanks, &tanks, 10);
    assert_eq!(reports[0].failed, 0);
}

#[test]
fn a_thrust_scale_error_hides_in_the_sine_and_shows_in_burst_and_coast() {
    let told = |slosh: Slosh| {
        let concealed = Concealed { thrust_scale_error: 0.01, bias_m_s2: 0.0 };
        let mut slosh = Slosh { concealed, ..slosh };
        slosh.settings.unknowns = SloshUnknowns::ParametersStateBias; // the scale is believed
        slosh
    };
    let (sine, burst) = (told(Slosh::bp2()), told(Slosh::burst()));
    for record in 0..6 {
        let [hidden, seen] = [&sine, &burst].map(|slosh| slosh.estimate(SEED, record).expect("slosh is there"));
        let off = |mass_kg: f64| mass_kg / sine.truth()[0] - 1.0;
        let [hidden_off, seen_off] = [&hidden, &seen].map(|estimate| off(estimate.hypothesis.parameters.slosh_mass_kg));
        let worst = |estimate: &physics::slosh_estimator::SloshEstimate| estimate.whiteness.worst_z_score();
        demand(&[
            // The independent study: −10.4 % with z of 0.5 and 0.3.
            Claim::within("sine: error of m_s", hidden_off, -0.13, -0.08),
            Claim::at_most("sine: worst z of block means", Some(worst(&hidden)), 5.0),
            // Without noise −2.2 % of m_s, −1.8 % of k_s and −9.1 % of c_s: what does not fit goes
            // into the start of the slosh (1.1 m). Four sigma of 0.4 % about it. Three cycles over
            // 1000 s move by −0.36, −0.22 and −2.0 % (the study's −0.6, −0.5 and −2.8 % hold its
            // noise draw of −0.3, −0.3 and −0.9 %). No degeneracy: with the scale free the bound of
            // m_s stays 0.40 %.
            Claim::within("burst: error of m_s", seen_off, -0.038, -0.006),
            // Misled as well, by less than half as much.
            Claim::at_most("burst: error of m_s over the sine's", Some((seen_off / hidden_off).abs()), 0.5),
            Claim::within("burst: worst z of block means", worst(&seen), 20.0, f64::INFINITY),
        ]);
    }
}
