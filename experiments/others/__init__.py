# SPDX-License-Identifier: Apache-2.0
"""The standard cases in other renderers: an independent check of tallow and of its reference.

scene           a tallow case as plain numbers
passes          means, variances and times of repeated renders; EXR files
mitsuba_render  Mitsuba 3: a volumetric path tracer
cycles_render   Blender's Cycles: random walk and Burley
check_scenes    are the scenes equal? silhouettes and irradiance, side by side
check_reference tallow-reference against Mitsuba
error_curve     error against seconds

Nothing is imported or rendered before a function is called. docs: experiments/others/README.md
"""
