"""The native half for processors with AVX2 (x86-64-v3)."""
