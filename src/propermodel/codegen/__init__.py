"""Programs and the machines that run them: native code through LLVM, and a NumPy interpreter as oracle."""
