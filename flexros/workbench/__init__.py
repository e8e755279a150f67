"""The workbench of `import flexros`: each task as one function, with results that show, plot and convert themselves."""
