"""Checks KEDA's objects in Kubernetes manifests against a model of its types: check_keda.py FILE…

Needs the package cloudcoil-models-keda.
"""

import sys

import cloudcoil.models.keda.v1alpha1 as keda
import yaml

KNOWN = {"ScaledObject": keda.ScaledObject, "TriggerAuthentication": keda.TriggerAuthentication}


def unknown(given, kept, place=""):
    """Places of what a model did not keep, which are misspelt names."""
    if isinstance(given, dict) and isinstance(kept, dict):
        for key, value in given.items():
            if key not in kept:
                yield f"{place}.{key}"
            else:
                yield from unknown(value, kept[key], f"{place}.{key}")
    elif isinstance(given, list) and isinstance(kept, list):
        for index, (value, other) in enumerate(zip(given, kept)):
            yield from unknown(value, other, f"{place}[{index}]")


def declared(model):
    """Turns a model into what it knows by name: values that it only carried along are left out."""
    if hasattr(model, "model_fields_set"):
        fields = type(model).model_fields
        return {(fields[name].alias or name): declared(getattr(model, name)) for name in model.model_fields_set if name in fields}
    if isinstance(model, list):
        return [declared(item) for item in model]
    if hasattr(model, "root"):
        return declared(model.root)
    return model


def main():
    count = 0
    for file in sys.argv[1:]:
        with open(file, encoding="utf-8") as text:
            for thing in yaml.safe_load_all(text):
                if not thing or not thing["apiVersion"].startswith("keda.sh/"):
                    continue
                model = KNOWN[thing["kind"]].model_validate(thing)
                wrong = list(unknown(thing["spec"], declared(model.spec)))
                if wrong:
                    sys.exit(f"{file}: {thing['kind']} has unknown {', '.join(wrong)}")
                count += 1
    print(f"{count} objects of KEDA are as its types say")


if __name__ == "__main__":
    main()
