//! JSON Schema of named numbers, for editors, generated from the same tables as everything else.

use super::{Domain, ParameterInfo};
use schemars::{Schema, json_schema};

/// A table of these parameters, with the values of an ideal device as defaults and no other keys.
pub(crate) fn table(known: &[ParameterInfo]) -> Schema {
    numbers(known, true)
}

/// The schema for a file that changes single parameters: the others keep their values.
pub(crate) fn changes(known: &[ParameterInfo]) -> Schema {
    numbers(known, false)
}

fn numbers(known: &[ParameterInfo], with_defaults: bool) -> Schema {
    let mut schema = json_schema!({
        "type": "object", "properties": {}, "additionalProperties": false
    });
    if let Some(properties) = schema.get_mut("properties").and_then(|it| it.as_object_mut()) {
        for info in known {
            let mut number = number(info.domain);
            number.insert("description".to_owned(), info.doc.trim().into());
            if with_defaults && info.ideal.is_finite() {
                number.insert("default".to_owned(), info.ideal.into());
            }
            properties.insert(info.name.to_owned(), number.into());
        }
    }
    schema
}

/// A number of `domain`. JSON has no infinity: programs that read TOML as JSON represent it as null.
fn number(domain: Domain) -> Schema {
    let mut schema = json_schema!({ "type": "number" });
    if domain.min == f64::MIN_POSITIVE {
        schema.insert("exclusiveMinimum".to_owned(), 0.into());
    } else if domain.min > f64::MIN {
        schema.insert("minimum".to_owned(), domain.min.into());
    }
    if domain.max == f64::INFINITY {
        return json_schema!({ "anyOf": [schema, { "enum": [null] }] });
    }
    if domain.max < f64::MAX {
        schema.insert("maximum".to_owned(), domain.max.into());
    }
    schema
}

#[cfg(test)]
mod tests {
    use super::{changes, number, table};
    use crate::gyro::GyroParameters;
    use crate::parameters::{Domain, Parameters};

    #[test]
    fn every_parameter_has_its_domain_and_its_ideal_value() {
        let schema = table(GyroParameters::TABLE);
        for info in GyroParameters::TABLE {
            let property = &schema.get("properties").unwrap()[info.name];
            let default = property.get("default").and_then(|default| default.as_f64());
            assert_eq!(
                default,
                Some(info.ideal).filter(|ideal| ideal.is_finite()),
                "{}",
                info.name
            );
            assert_eq!(property["description"], info.doc.trim());
        }
        let changed = changes(GyroParameters::TABLE);
        assert!(
            changed
                .get("properties")
                .unwrap()
                .as_object()
                .unwrap()
                .values()
                .all(|it| it.get("default").is_none())
        );
    }

    #[test]
    fn domains_become_bounds() {
        assert!(number(Domain::FINITE).get("minimum").is_none());
        assert_eq!(number(Domain::NOT_NEGATIVE).get("minimum").unwrap(), 0.0);
        assert_eq!(number(Domain::POSITIVE).get("exclusiveMinimum").unwrap(), 0);
        assert_eq!(number(Domain::CELSIUS).get("maximum").unwrap(), 1e3);
        assert!(number(Domain::LIMIT).get("anyOf").is_some());
    }
}
