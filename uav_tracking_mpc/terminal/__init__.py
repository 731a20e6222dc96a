"""Terminal ingredients, their proof, certificates."""
