"""Mistakes that type checkers must find: each comment gives the code of mypy's error."""

import woundon as wo

steel = wo.Isotropic(youngs_modulus=206e9, poissons_ratio=0.3)
wo.Rigid(radius=[0.1])  # arg-type
wo.Rigid(radus=0.1)  # call-arg
wo.Cylinder(radius=0.1, core_radius=None, material=steel)  # arg-type
wo.HalfPlane(radius=0.1)  # call-arg
wo.Web(thickness="66 um", material=3.0)  # arg-type
diameter = wo.Rigid(diameter=0.2).diameter  # attr-defined
wo.NipProblem.example().nip_load.upper()  # attr-defined
