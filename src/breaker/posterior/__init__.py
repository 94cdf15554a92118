"""Posteriors of records: trained networks, their correction to the exact posterior, and checks.

``Posterior`` holds a trained network and its settings in one file; it draws, evaluates its density
and predicts records. Importance sampling corrects its draws and measures its error. Needs torch.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "batches": ["OnlineRows", "Rows", "StreamedRows", "freeze_inputs", "split"],
        "corrections": ["Corrected", "correct"],
        "estimator": ["Posterior"],
        "exactness": ["correct_validation", "judge"],
        "family_network": ["FamilyNetwork", "FamilyRows"],
        "predictive": [
            "infer",
            "predict",
            "predict_stages",
            "sample_records",
            "validate",
        ],
        "solver": ["convergence", "held_out_log_density", "records"],
        "tables": [
            "intervals",
            "quantiles",
            "share_inside",
            "summary",
            "table",
        ],
        "training": ["Checkpoint", "Trainer", "choose_device", "fingerprint"],
        "weights": ["importance"],
    },
)
