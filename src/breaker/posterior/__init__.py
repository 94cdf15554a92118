"""From records to posteriors: amortised by networks, brought to the exact one, and judged.

``Posterior`` is trained on a bank and saved as one file; draws, intervals and predictive checks
follow; importance sampling corrects and judges it. The room that needs torch.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "batches": ["Rows", "freeze_inputs", "split"],
        "corrections": ["Corrected", "correct"],
        "estimator": ["Posterior"],
        "exactness": [
            "beside",
            "choose",
            "correct_operations",
            "correct_validation",
            "judge",
            "summary",
            "table_of_both",
        ],
        "missing": ["widening"],
        "predictive": ["infer", "predict", "predict_stages", "sample_records", "table", "validate"],
        "solver": ["convergence", "held_out_log_density", "records"],
        "training": ["Trainer", "choose_device", "fingerprint"],
        "weights": ["importance"],
    },
)
