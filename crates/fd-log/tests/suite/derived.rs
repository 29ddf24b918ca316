//! Channels that are computed from columns.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]
#![allow(clippy::float_cmp, reason = "what is compared so is exact")]

use fd_log::{Log, LogMap, read_log_from};

const CSV: &str = "t,u [V],i [mA],q [deg],/arm.q[0]\n0,2,500,180,1\n1,4,,90,2\n2,6,1000,0,3\n";

fn read(map: &str) -> Result<Log, String> {
    let map: LogMap = toml::from_str(map).unwrap();
    read_log_from("run.csv", CSV.as_bytes(), &map).map_err(|error| error.to_string())
}

#[test]
fn names_are_columns_in_their_units_or_in_those_that_the_map_says() {
    let log = read(
        "inputs = [{ name = 'power', unit = 'kW', column_unit = 'W', expression = 'u*current' }]\n\
         outputs = [{ name = 'lag', unit = 'rad', expression = 'angle - 2*pi*rate*t + arm' }]\n\
         columns = [{ name = 'current', column = 'i', unit = 'A' }, { name = 'rate', constant = 0.25 },\n\
                    { name = 'angle', column = 'q', unit = 'rad' }, { name = 'arm', column = '/arm.q[0]' }]",
    )
    .unwrap();
    let pi = std::f64::consts::PI;
    for (k, (power, lag)) in
        [(0.001, pi + 1.0), (f64::NAN, 2.0), (0.006, 3.0 - pi)].into_iter().enumerate()
    {
        let found = (log.record.u(k)[0], log.record.y(k)[0]);
        // A product and a few sums of numbers of order one.
        assert!((found.0 - power).abs() < 1e-15 || found.0.is_nan() && power.is_nan(), "{k}");
        assert!((found.1 - lag).abs() < 1e-14, "{k}: {} {lag}", found.1);
    }
    assert_eq!(log.record.inputs()[0].unit, "kW");
}

#[test]
fn a_missing_value_is_missing_whatever_the_expression_makes_of_it() {
    let log =
        read("outputs = [{ name = 'y', expression = 'max(i, 1) + if(i > 0, 1, 2)' }]").unwrap();
    assert_eq!((log.record.y(0)[0], log.record.y(2)[0]), (501.0, 1001.0));
    assert!(log.record.y(1)[0].is_nan());
}

#[test]
fn what_is_wrong_is_said() {
    let said = |map: &str| read(map).unwrap_err();
    let output = |rest: &str| format!("outputs = [{{ name = 'y', {rest} }}]");
    assert!(
        said(&output("expression = 'u +'")).contains("channel `y`: expression: expected"),
        "{}",
        said(&output("expression = 'u +'"))
    );
    let typo = said(
        "outputs = [{ name = 'y', expression = '2*curent' }]\n\
                     columns = [{ name = 'current', column = 'i' }]",
    );
    assert!(typo.ends_with("did you mean `current`?"), "{typo}");
    assert!(said(&output("expression = 'u', column = 'u'")).contains("found a `column`"));
    assert!(said(&output("expression = 'u', unit = 'kW', column_unit = 'V'")).contains("`y = u`"));
    let zero = said(&output("expression = '1/(u - 4)'"));
    assert!(zero.contains("row 3: expected a finite number, found `inf`"), "{zero}");
    assert!(
        said(&output("expression = 'sqrt(u - 3)'"))
            .contains("row 2: expected a finite number, found `NaN`")
    );
    assert!(said(&output("expression = 'dt*u'")).contains("`dt` is no column of the file"));
}
