"""`lingual bench`: how fast every solver is on this machine, on meshes of three sizes."""
