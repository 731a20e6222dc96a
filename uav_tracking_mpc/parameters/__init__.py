"""Parameters described once, and what people add found by name. Imports nothing of the package.

==================  ==================================================================
``specification``   name, type, default, unit, meaning, allowed values of a parameter
``registry``        laws, limits, plants, faults by name, entry point or file
``conformance``     what an extension must keep, said in words where it does not
==================  ==================================================================
"""
