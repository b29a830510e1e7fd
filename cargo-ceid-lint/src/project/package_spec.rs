//! Package specifications: names, `name@version`, patterns, and full package ids as editors send them.

use super::workspace::Found;
use crate::config::glob;

/// Whether `spec` names the package.
pub(super) fn matches(spec: &str, found: &Found) -> bool {
    if spec == found.id || is_old_id(spec, found) {
        return true;
    }
    if spec.contains("://") {
        return matches_url(spec, found);
    }
    match spec.split_once('@').or_else(|| spec.split_once(':')) {
        Some((name, version)) => glob::matches(name, &found.name) && matches_version(version, &found.version),
        None => glob::matches(spec, &found.name),
    }
}

/// `name 0.1.0 (path+file:///…)`, the form before cargo 1.77.
fn is_old_id(spec: &str, found: &Found) -> bool {
    let mut words = spec.splitn(3, ' ');
    let (Some(name), Some(version), Some(source)) = (words.next(), words.next(), words.next()) else { return false };
    let url = found.id.split('#').next().unwrap_or_default();
    name == found.name && version == found.version && source == format!("({url})")
}

fn matches_url(spec: &str, found: &Found) -> bool {
    let (url, fragment) = spec.split_once('#').unwrap_or((spec, ""));
    let (own_url, _) = found.id.split_once('#').unwrap_or((&found.id, ""));
    let bare = |url: &str| url.split_once('+').map_or(url, |(_, rest)| rest).trim_end_matches('/').to_owned();
    if bare(url) != bare(own_url) {
        return false;
    }
    match fragment.split_once('@').or_else(|| fragment.split_once(':')) {
        Some((name, version)) => name == found.name && matches_version(version, &found.version),
        None if fragment.is_empty() => true,
        None if fragment.starts_with(|c: char| c.is_ascii_digit()) => matches_version(fragment, &found.version),
        None => fragment == found.name,
    }
}

/// Whether the parts of a version that are named agree: `1.2` names `1.2.3`.
fn matches_version(spec: &str, version: &str) -> bool {
    version == spec || version.strip_prefix(spec).is_some_and(|rest| rest.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(spec: &str, expected: bool) {
        let found = Found {
            name: "control".to_owned(),
            version: "1.2.3".to_owned(),
            id: "path+file:///ws/control#1.2.3".to_owned(),
            ..Found::default()
        };
        assert_eq!(matches(spec, &found), expected, "{spec}");
    }

    #[test]
    fn a_name_or_a_pattern() {
        check("control", true);
        check("con*", true);
        check("contro", false);
        check("*hal", false);
    }

    #[test]
    fn a_name_with_a_version() {
        check("control@1.2.3", true);
        check("control@1.2", true);
        check("control:1", true);
        check("control@1.3", false);
        check("other@1.2.3", false);
    }

    #[test]
    fn a_full_package_id() {
        check("path+file:///ws/control#1.2.3", true);
        check("file:///ws/control", true);
        check("path+file:///ws/control#control@1.2.3", true);
        check("path+file:///ws/control#9.9.9", false);
        check("path+file:///elsewhere/control#1.2.3", false);
        check("control 1.2.3 (path+file:///ws/control)", true);
    }
}
