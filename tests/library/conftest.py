"""The trucks, compiled once."""

import pytest

from propermodel.compiler import CompiledModel, compile_model
from propermodel.library.vehicle.truck import ConventionalTruck, HybridTruck
from propermodel.modelling import elaborate


@pytest.fixture(scope="session")
def hybrid() -> CompiledModel:
    return compile_model(elaborate(HybridTruck()))


@pytest.fixture(scope="session")
def conventional() -> CompiledModel:
    return compile_model(elaborate(ConventionalTruck()))
