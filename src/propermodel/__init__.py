"""Physical models from bond graphs, and the simplest of them whose answers are still good.

Component -> Model -> CompiledModel -> Trajectory -> ActivityRanking -> Reduction. Models can be written without loading
what compiles, runs and reduces them: those names are imported when first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from propermodel.diagnostics import ModelWarning, Path, ProperModelError
from propermodel.expressions import (
    Expr,
    absolute,
    atan,
    atan2,
    clip,
    cos,
    equals,
    exp,
    floor,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tan,
    tanh,
    time,
    where,
)
from propermodel.modelling import (
    Compliance,
    Component,
    ConstantEffort,
    ConstantFlow,
    Controller,
    Cut,
    Discrete,
    Domain,
    EffortSource,
    Electrical,
    FlowSource,
    Freeze,
    Gyrator,
    Hydraulic,
    Inertia,
    Input,
    KinematicTransformer,
    Limits,
    Merge,
    Model,
    MultiportCompliance,
    MultiportInertia,
    MultiportResistance,
    OneJunction,
    Output,
    Parameter,
    Port,
    Preference,
    Prescribe,
    PseudoThermal,
    Removal,
    Resistance,
    Rotation,
    Scenario,
    SignalBlock,
    State,
    TableValues,
    Thermal,
    Transformer,
    Translation,
    Updates,
    VectorPort,
    ZeroEffort,
    ZeroFlow,
    ZeroJunction,
    activated_bond,
    bond,
    chain,
    connect,
    elaborate,
    evaluate,
    free,
    measured,
    parameter,
    prescribed_effort,
    prescribed_flow,
    quantity,
    repeat,
    replace,
    table,
    table_values,
    when,
)

if TYPE_CHECKING:
    from propermodel.analysis.activity import rank_activity
    from propermodel.analysis.balance import EnergyBalance, energy_balance
    from propermodel.analysis.bond_ranking import BondRanking, rank_bonds
    from propermodel.analysis.comparison import Comparison, OutputError, compare
    from propermodel.analysis.datum import measure_about
    from propermodel.analysis.frequency_ranking import rank_frequencies
    from propermodel.analysis.linear_model import LinearModel
    from propermodel.analysis.linearise import linearise
    from propermodel.analysis.modes import Mode, Modes
    from propermodel.analysis.ranking import ActivityRanking
    from propermodel.analysis.recorded import RecordedElement, rank_recorded
    from propermodel.analysis.responses import FrequencyResponse, TimeResponse
    from propermodel.analysis.sensitivities import Sensitivities, sensitivities
    from propermodel.analysis.tolerances import Tolerance
    from propermodel.analysis.transfer import TransferFunction
    from propermodel.causality.report import CausalReport, explain_causality
    from propermodel.compiler import Backend, CompiledModel, Method, compile_model
    from propermodel.drawing.depict import depict
    from propermodel.drawing.picture import Picture
    from propermodel.drawing.svg import to_svg
    from propermodel.equations.matrices import SymbolicMatrices, symbolic_matrices
    from propermodel.equations.readable import ReadableEquations, state_equations
    from propermodel.exchange.python import write_python
    from propermodel.modelling.documents import read_model, read_scenario, write_model, write_scenario
    from propermodel.reduction.candidates import Candidate, ProperModelSearch
    from propermodel.reduction.certificate import Certificate
    from propermodel.reduction.certificate_files import read_certificate, write_certificate
    from propermodel.reduction.certify import CertifiedModel, certify
    from propermodel.reduction.merges import MergedElement, find_merges
    from propermodel.reduction.methods.compare import MethodComparison, compare_methods
    from propermodel.reduction.methods.curve import Curve
    from propermodel.reduction.methods.workbench import SizedModel
    from propermodel.reduction.part_runs import PartRuns, part_model, simulate_parts
    from propermodel.reduction.partition import Partition, partition
    from propermodel.reduction.plan import Reduction, plan_reduction
    from propermodel.reduction.prediction import PredictedError, Prediction, predict_errors
    from propermodel.reduction.search import find_proper_model
    from propermodel.reduction.singular import SingularRemovals, explain_removals
    from propermodel.reduction.verify import Verification, verify_certificate
    from propermodel.report.certify import certify_study
    from propermodel.report.options import StudyOptions
    from propermodel.report.study import ReductionStudy, run_study
    from propermodel.simulation.ensemble import Ensemble, designs, simulate_many
    from propermodel.simulation.equilibrium import Equilibrium, find_equilibrium
    from propermodel.simulation.simulate import simulate
    from propermodel.simulation.stability import StepLimit, step_limit
    from propermodel.simulation.storage import load_trajectory, save_trajectory
    from propermodel.simulation.trajectory import Trajectory

    __version__: str

_WHEN_USED = {
    "ActivityRanking": "analysis.ranking",
    "Backend": "compiler",
    "CausalReport": "causality.report",
    "Certificate": "reduction.certificate",
    "CertifiedModel": "reduction.certify",
    "Comparison": "analysis.comparison",
    "CompiledModel": "compiler",
    "EnergyBalance": "analysis.balance",
    "Equilibrium": "simulation.equilibrium",
    "FrequencyResponse": "analysis.responses",
    "LinearModel": "analysis.linear_model",
    "Method": "compiler",
    "Mode": "analysis.modes",
    "Modes": "analysis.modes",
    "ReadableEquations": "equations.readable",
    "Reduction": "reduction.plan",
    "OutputError": "analysis.comparison",
    "PredictedError": "reduction.prediction",
    "Candidate": "reduction.candidates",
    "ProperModelSearch": "reduction.candidates",
    "Prediction": "reduction.prediction",
    "ReductionStudy": "report.study",
    "Sensitivities": "analysis.sensitivities",
    "SingularRemovals": "reduction.singular",
    "MergedElement": "reduction.merges",
    "find_merges": "reduction.merges",
    "Partition": "reduction.partition",
    "partition": "reduction.partition",
    "PartRuns": "reduction.part_runs",
    "part_model": "reduction.part_runs",
    "simulate_parts": "reduction.part_runs",
    "StudyOptions": "report.options",
    "SymbolicMatrices": "equations.matrices",
    "TimeResponse": "analysis.responses",
    "Tolerance": "analysis.tolerances",
    "Trajectory": "simulation.trajectory",
    "TransferFunction": "analysis.transfer",
    "Verification": "reduction.verify",
    "certify": "reduction.certify",
    "certify_study": "report.certify",
    "compare": "analysis.comparison",
    "compile_model": "compiler",
    "depict": "drawing.depict",
    "to_svg": "drawing.svg",
    "Picture": "drawing.picture",
    "energy_balance": "analysis.balance",
    "explain_removals": "reduction.singular",
    "explain_causality": "causality.report",
    "find_equilibrium": "simulation.equilibrium",
    "StepLimit": "simulation.stability",
    "step_limit": "simulation.stability",
    "linearise": "analysis.linearise",
    "load_trajectory": "simulation.storage",
    "plan_reduction": "reduction.plan",
    "predict_errors": "reduction.prediction",
    "find_proper_model": "reduction.search",
    "compare_methods": "reduction.methods.compare",
    "MethodComparison": "reduction.methods.compare",
    "Curve": "reduction.methods.curve",
    "SizedModel": "reduction.methods.workbench",
    "rank_activity": "analysis.activity",
    "rank_bonds": "analysis.bond_ranking",
    "measure_about": "analysis.datum",
    "rank_frequencies": "analysis.frequency_ranking",
    "BondRanking": "analysis.bond_ranking",
    "rank_recorded": "analysis.recorded",
    "RecordedElement": "analysis.recorded",
    "read_certificate": "reduction.certificate_files",
    "read_model": "modelling.documents",
    "read_scenario": "modelling.documents",
    "run_study": "report.study",
    "save_trajectory": "simulation.storage",
    "simulate": "simulation.simulate",
    "simulate_many": "simulation.ensemble",
    "designs": "simulation.ensemble",
    "Ensemble": "simulation.ensemble",
    "sensitivities": "analysis.sensitivities",
    "state_equations": "equations.readable",
    "symbolic_matrices": "equations.matrices",
    "verify_certificate": "reduction.verify",
    "write_certificate": "reduction.certificate_files",
    "write_model": "modelling.documents",
    "write_python": "exchange.python",
    "write_scenario": "modelling.documents",
}

__all__ = [
    # components and their parts
    "Component",
    "Port",
    "Preference",
    "PseudoThermal",
    "Parameter",
    "parameter",
    "table",
    "table_values",
    "quantity",
    "repeat",
    "replace",
    # elements and junctions
    "Resistance",
    "Compliance",
    "Inertia",
    "KinematicTransformer",
    "EffortSource",
    "FlowSource",
    "Transformer",
    "Gyrator",
    "MultiportResistance",
    "MultiportCompliance",
    "MultiportInertia",
    "ZeroJunction",
    "OneJunction",
    # connections
    "connect",
    "bond",
    "activated_bond",
    "chain",
    "free",
    "measured",
    "prescribed_effort",
    "prescribed_flow",
    # domains
    "Domain",
    "Translation",
    "Rotation",
    "Hydraulic",
    "Thermal",
    "Electrical",
    # signals
    "Controller",
    "SignalBlock",
    "Input",
    "Output",
    "Discrete",
    "State",
    "Updates",
    "VectorPort",
    "when",
    # laws
    "Expr",
    "absolute",
    "atan",
    "atan2",
    "clip",
    "cos",
    "equals",
    "exp",
    "floor",
    "log",
    "maximum",
    "minimum",
    "sign",
    "sin",
    "sqrt",
    "tan",
    "tanh",
    "time",
    "where",
    "evaluate",
    # model and scenario
    "Path",
    "ProperModelError",
    "ModelWarning",
    "Model",
    "elaborate",
    "Scenario",
    "TableValues",
    "Limits",
    "read_model",
    "write_model",
    "write_python",
    "read_scenario",
    "write_scenario",
    # compiling and running
    "compile_model",
    "CompiledModel",
    "Backend",
    "Method",
    "explain_causality",
    "CausalReport",
    "state_equations",
    "ReadableEquations",
    "symbolic_matrices",
    "SymbolicMatrices",
    "simulate",
    "Trajectory",
    "designs",
    "simulate_many",
    "Ensemble",
    "save_trajectory",
    "load_trajectory",
    "step_limit",
    "StepLimit",
    # equilibria and linear models
    "find_equilibrium",
    "Equilibrium",
    "linearise",
    "LinearModel",
    "Modes",
    "Mode",
    "FrequencyResponse",
    "TimeResponse",
    "TransferFunction",
    # sensitivities
    "sensitivities",
    "Sensitivities",
    # activity and energy
    "rank_activity",
    "rank_bonds",
    "rank_frequencies",
    "measure_about",
    "rank_recorded",
    "RecordedElement",
    "ActivityRanking",
    "BondRanking",
    "energy_balance",
    "EnergyBalance",
    # reduction
    "predict_errors",
    "Prediction",
    "PredictedError",
    "find_proper_model",
    "Tolerance",
    "ProperModelSearch",
    "Candidate",
    "compare_methods",
    "MethodComparison",
    "Curve",
    "SizedModel",
    "plan_reduction",
    "Reduction",
    "explain_removals",
    "SingularRemovals",
    "find_merges",
    "MergedElement",
    "partition",
    "Partition",
    "part_model",
    "simulate_parts",
    "PartRuns",
    "Removal",
    "ZeroEffort",
    "ZeroFlow",
    "ConstantEffort",
    "ConstantFlow",
    "Cut",
    "Prescribe",
    "Merge",
    "Freeze",
    "compare",
    "Comparison",
    "OutputError",
    "run_study",
    "StudyOptions",
    "ReductionStudy",
    # pictures
    "depict",
    "Picture",
    "to_svg",
    # certificates
    "certify",
    "certify_study",
    "CertifiedModel",
    "Certificate",
    "write_certificate",
    "read_certificate",
    "verify_certificate",
    "Verification",
]


def __getattr__(name: str) -> Any:
    """Names of the rooms that compile, run and reduce; and the version."""
    if name == "__version__":
        from propermodel.codegen.versions import package_version

        value: Any = package_version()
    elif name in _WHEN_USED:
        value = getattr(import_module(f"propermodel.{_WHEN_USED[name]}"), name)
    else:
        raise AttributeError(f"module 'propermodel' has no attribute '{name}'")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
